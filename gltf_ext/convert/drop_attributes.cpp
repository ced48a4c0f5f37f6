#include "gltf_ext/convert/drop_attributes.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>

#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/convert/texture_reads.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {
namespace {

// "TEXCOORD_1" is set 1 of TEXCOORD.
struct SetName {
  std::string prefix;  // with the underscore
  int64_t set = 0;
};
std::optional<SetName> set_name(const std::string& semantic) {
  const size_t underscore = semantic.rfind('_');
  if (underscore == std::string::npos) return std::nullopt;
  SetName name{semantic.substr(0, underscore + 1)};
  const char* const end = semantic.data() + semantic.size();
  const auto parsed = std::from_chars(semantic.data() + underscore + 1, end, name.set);
  return parsed.ec == std::errc() && parsed.ptr == end && name.set >= 0 ? std::optional(name) : std::nullopt;
}

class Dropper {
 public:
  Dropper(Document& document, const EncodeDocumentOptions& options)
      : document_(document),
        options_(options),
        named_(options.skip.begin(), options.skip.end()),
        metadata_(metadata_attributes(document.json())) {
    for_each_element(document.json(), "nodes", [&](const Json& node) {
      if (const auto mesh = integer_field(node, "mesh"); mesh && field(node, "skin") != nullptr)
        skinned_.insert(*mesh);
    });
  }

  Status drop(PrimitiveId id) {
    Json& primitive = primitive_json(document_, id);
    Json* const attributes = object_field(primitive, "attributes");
    if (attributes == nullptr) return {};
    const auto to_skip = [&] {
      std::vector<std::string> found;
      for (const auto& [semantic, index] : attributes->items())
        if (skip_.contains(semantic)) found.push_back(semantic);
      return found;
    };
    skip_ = named_;
    std::vector<std::string> found = to_skip();
    const bool is_named = !found.empty();
    add_unused(primitive, *attributes, id);
    if (named_.contains(kUnusedAttributes)) {
      found = to_skip();
      if (!found.empty() && !is_named) dropped_.before[id] = primitive;
    } else {
      std::vector<std::string> unused = to_skip();
      if (!is_named && !unused.empty() && !materials_of(primitive).empty())
        dropped_.unused[id] = std::move(unused);
      skip_ = named_;
    }
    for (const std::string& semantic : found)
      if (const std::string reason = need(primitive, id, semantic); !reason.empty())
        return Status(StatusCode::kUsage, semantic + " cannot be skipped: " + reason, place_of(document_, id));
    for (const std::string& semantic : found) {
      release(*attributes, semantic);
      for_each_element(primitive, "targets", [&](Json& target) {
        if (target.is_object()) release(target, semantic);
      });
      for (const char* name : {kExtensionName, kStockExtensionName})
        if (Json* extension = extension_field(primitive, name))
          if (Json* stored = object_field(*extension, "attributes")) stored->erase(semantic);
    }
    if (!found.empty()) dropped_.of_primitive[id] = std::move(found);
    return {};
  }

  DroppedAttributes dropped() && { return std::move(dropped_); }

 private:
  void release(Json& holder, const std::string& semantic) {
    if (const auto accessor = integer_field(holder, semantic.c_str())) dropped_.freed.push_back(*accessor);
    holder.erase(semantic);
  }

  // Adds the attributes that nothing reads to those to skip. A set may go only after the sets that follow it.
  void add_unused(const Json& primitive, const Json& attributes, PrimitiveId id) {
    std::map<std::string, std::set<int64_t>> sets;  // by prefix
    for (const auto& [semantic, index] : attributes.items())
      if (const std::optional<SetName> name = set_name(semantic)) sets[name->prefix].insert(name->set);
    const auto try_one = [&](const std::vector<std::string>& semantics) {
      std::set<std::string> before = skip_;
      skip_.insert(semantics.begin(), semantics.end());
      const bool is_unused = std::all_of(semantics.begin(), semantics.end(), [&](const std::string& semantic) {
        return !attributes.contains(semantic) || need(primitive, id, semantic).empty();
      });
      if (!is_unused) skip_ = std::move(before);
      return is_unused;
    };
    const auto try_sets = [&](const char* prefix, const char* pair, int64_t least) {
      const std::set<int64_t>& found = sets[prefix];
      for (auto set = found.rbegin(); set != found.rend() && *set >= least; ++set) {
        std::vector<std::string> semantics{prefix + std::to_string(*set)};
        if (pair != nullptr) semantics.push_back(pair + std::to_string(*set));
        if (!try_one(semantics)) return;
      }
    };
    try_sets("TEXCOORD_", nullptr, 0);
    try_sets("COLOR_", nullptr, 1);  // materials are multiplied by COLOR_0
    if (!skinned_.contains(static_cast<int64_t>(id.mesh))) try_sets("JOINTS_", "WEIGHTS_", 0);
    if (!reads_tangents(primitive)) try_one({"TANGENT"});
  }

  bool reads_tangents(const Json& primitive) const {
    for (const int64_t material : materials_of(primitive))
      if (const Json* object = top_level_object(document_.json(), "materials", material))
        if (has_key_with(*object, "ormalTexture") || has_key_with(*object, "nisotropy")) return true;
    return false;
  }

  // Whether the name of a field at any depth has this part.
  static bool has_key_with(const Json& tree, const char* part) {
    if (!tree.is_structured()) return false;
    for (const auto& [key, value] : tree.items())
      if ((tree.is_object() && key.find(part) != std::string::npos) || has_key_with(value, part)) return true;
    return false;
  }

  // Why the attribute must stay; empty if it need not.
  std::string need(const Json& primitive, PrimitiveId id, const std::string& semantic) const {
    if (semantic == "POSITION") return "a mesh needs positions";
    if (extension_field(primitive, kExtensionName) != nullptr && options_.compat == Compat::kNone)
      return "it is in patches, which stay as they are; decode the asset first";
    if (metadata_.contains(semantic)) return "EXT_structural_metadata reads it";
    std::string reason;
    for_each_element(primitive, "targets", [&](const Json& target) {
      const auto is_dropped = [&](const auto& member) { return skip_.contains(member.key()); };
      const auto members = target.items();
      if (target.is_object() && target.contains(semantic) &&
          std::all_of(members.begin(), members.end(), is_dropped))
        reason = "a morph target would be empty";
    });
    const std::optional<SetName> name = set_name(semantic);
    if (!reason.empty() || !name) return reason;
    return need_of_set(primitive, id, *name);
  }

  std::string need_of_set(const Json& primitive, PrimitiveId id, const SetName& name) const {
    const auto stays = [&](const std::string& other) {
      return field(primitive["attributes"], other.c_str()) != nullptr && !skip_.contains(other);
    };
    if (name.prefix == "_FEATURE_ID_") return need_of_feature(primitive, name.set);
    if (name.prefix.starts_with('_')) return "";
    // glTF counts sets from 0 without gaps.
    if (const std::string next = name.prefix + std::to_string(name.set + 1); stays(next))
      return next + " would stay without it; skip that as well";
    if (name.prefix == "JOINTS_" || name.prefix == "WEIGHTS_") {
      const std::string other = (name.prefix == "JOINTS_" ? "WEIGHTS_" : "JOINTS_") + std::to_string(name.set);
      if (stays(other)) return other + " would stay without it; skip that as well";
      if (name.set == 0 && skinned_.contains(static_cast<int64_t>(id.mesh))) return "a skin needs it";
    }
    return name.prefix == "TEXCOORD_" ? need_of_texture(primitive, name.set) : "";
  }

  static std::string need_of_feature(const Json& primitive, int64_t set) {
    const Json* features = extension_field(primitive, "EXT_mesh_features");
    std::string reason;
    if (features != nullptr)
      for_each_element(*features, "featureIds", [&](const Json& feature) {
        if (integer_field(feature, "attribute") == set) reason = "EXT_mesh_features reads it";
      });
    return reason;
  }

  std::string need_of_texture(const Json& primitive, int64_t set) const {
    const auto reads = [&](const Json* tree) {
      TextureReads sets;
      if (tree != nullptr) collect_texture_reads(*tree, sets);
      return sets.contains(set);
    };
    for (const int64_t material : materials_of(primitive))
      if (reads(top_level_object(document_.json(), "materials", material)))
        return "material " + std::to_string(material) + " has a texture that reads it";
    if (reads(extension_field(primitive, "EXT_mesh_features"))) return "EXT_mesh_features reads it";
    const Json* metadata = extension_field(document_.json(), "EXT_structural_metadata");
    if (metadata != nullptr && extension_field(primitive, "EXT_structural_metadata") != nullptr &&
        reads(field(*metadata, "propertyTextures")))
      return "EXT_structural_metadata reads it";
    return "";
  }

  Document& document_;
  const EncodeDocumentOptions& options_;
  const std::set<std::string> named_, metadata_;
  std::set<std::string> skip_;  // of the primitive that is at work
  std::set<int64_t> skinned_;   // meshes
  DroppedAttributes dropped_;
};

}  // namespace

Expected<DroppedAttributes> drop_attributes(Document& document, const EncodeDocumentOptions& options,
                                            std::span<const PrimitiveId> ids) {
  Dropper dropper(document, options);
  for (const PrimitiveId id : ids)
    if (Status status = dropper.drop(id); !status.ok()) return status;
  return std::move(dropper).dropped();
}

void drop_manifolds(Document& document, std::span<const EncodeJob> jobs, PrimitiveEditor& editor,
                    EncodeReports& reports) {
  constexpr const char* kManifold = "EXT_mesh_manifold";
  std::set<size_t> dropped;
  for (const EncodeJob& job : jobs) {
    for (const PrimitiveId id : job.group.ids) {
      Json& mesh = document.json()["meshes"][id.mesh];
      if (const Json* manifold = extension_field(mesh, kManifold)) {
        for (const char* name : {"mergeIndices", "mergeValues"})
          if (const auto accessor = integer_field(*manifold, name)) editor.release(*accessor);
        if (const Json* primitive = object_field(*manifold, "manifoldPrimitive"))
          if (const auto accessor = integer_field(*primitive, "indices")) editor.release(*accessor);
        mesh["extensions"].erase(kManifold);
        if (mesh["extensions"].empty()) mesh.erase("extensions");
        dropped.insert(id.mesh);
      }
      if (dropped.contains(id.mesh))
        reports[id].warnings.push_back(std::string(kManifold) + " is dropped: its data refer to indices");
    }
  }
  if (!dropped.empty()) unlist_unused_extension(document, kManifold);
}

}  // namespace psplit
