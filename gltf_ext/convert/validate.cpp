#include "gltf_ext/convert/validate.h"

#include <algorithm>
#include <cstring>

#include "encoder/stitching/stitch_map.h"
#include "gltf_ext/document/linked_files.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/json/json_fields.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"

namespace psplit {
namespace {

// rule              what it says
// ----------------  ------------------------------------------------------------------------------------
// extension-used    extensionsUsed lists the extension when a primitive has it
// extension-required  extensionsRequired lists it when a primitive has no fallback
// extension-unused  a list names the extension, but no primitive has it (warning)
// mode              a primitive with patches is a triangle list
// members           bufferView and attributes are there and refer to what exists
// exclusion         no stock Draco on the same primitive, no sparse accessor, no compression of the container
// container         header, directory and lengths obey the specification's appendix
// decode            every stream decodes to what the directory says, and every reference resolves
// attribute-type    every stream stores the component types that the accessors state
// copies            all copies of a point in patches decode to the same bits
// accessor-count    accessors count what is decoded: a value a point, three indices a face
// accessor-bounds   min and max are those of the decoded values
// index-type        indices are scalars of a component type that holds every index
// fallback          accessors with data of their own hold what the patches decode to
// attribute-extra   an attribute of the primitive that the patches do not have (warning)
// geometry          what is not in patches can be read: accessors, indices, stock Draco, morph targets
// linked-file       a file that an image or an extension names is there, at a relative path (warning)
//
// gltf_ext/PSPLIT_mesh_draco_patches/README.md is the specification.

bool lists(const Json& json, const char* list, const char* name) {
  const Json* names = array_field(json, list);
  return names != nullptr && std::find(names->begin(), names->end(), Json(name)) != names->end();
}

class Validator {
 public:
  Validator(const Document& document, const DecodeBackend& backend, const ThreadPool& pool)
      : document_(document), backend_(backend), pool_(pool) {}

  std::vector<Finding> run() {
    for (const PrimitiveId id : all_primitives(document_)) {
      if (has_patches(id))
        check_primitive(id);
      else
        check_geometry(id);
    }
    check_lists();
    for (const LinkedFile& link : linked_files(document_))
      if (const std::string text = describe_dangling(link); !text.empty()) report("linked-file", text, false);
    return std::move(findings_);
  }

  // As far as it goes without every stream on its own.
  std::vector<Finding> run_on_decoded(std::span<const PrimitiveId> ids, std::span<const Mesh* const> meshes) {
    for (size_t i = 0; i < ids.size(); ++i) {
      place_ = place_of(ids[i]);
      const Expected<StoredPrimitive> patched = stored_primitive(document_, ids[i], kExtensionName);
      if (patched)
        check_decoded(json_of(ids[i]), patched->requests, *meshes[i]);
      else
        report("members", patched.status());
    }
    check_lists();
    return std::move(findings_);
  }

 private:
  Place place_of(PrimitiveId id) const {
    return {document_.source.string(), static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1};
  }
  const Json& json_of(PrimitiveId id) const {
    return document_.json["meshes"][id.mesh]["primitives"][id.primitive];
  }
  bool has_patches(PrimitiveId id) const {
    const Json* extensions = object_field(json_of(id), "extensions");
    return extensions != nullptr && field(*extensions, kExtensionName) != nullptr;
  }

  void check_lists() {
    place_ = {.file = document_.source.string()};
    bool any = false, any_without_fallback = false;
    for (const PrimitiveId id : all_primitives(document_)) {
      if (!has_patches(id)) continue;
      any = true;
      any_without_fallback |= !has_fallback(json_of(id));
    }
    const bool used = lists(document_.json, "extensionsUsed", kExtensionName);
    const bool required = lists(document_.json, "extensionsRequired", kExtensionName);
    if (any && !used) report("extension-used", "extensionsUsed does not list the extension");
    if (any_without_fallback && !required)
      report("extension-required",
             "a primitive has no fallback, but extensionsRequired does not list the extension");
    if (!any && (used || required))
      report("extension-unused", "the extension is listed, but nothing uses it", false);
  }

  // What encode would read; lines and points, and what only other software knows, pass through it.
  void check_geometry(PrimitiveId id) {
    place_ = place_of(id);
    const Status status = check_readable(document_, id, backend_, pool_);
    if (status.code() == StatusCode::kInvalidInput) report("geometry", status);
  }

  void report(const char* rule, std::string message, bool error = true) {
    findings_.push_back({rule, std::move(message), place_, error});
  }
  void report(const char* rule, const Status& status) {
    findings_.push_back({rule, status.message(), Status(status).at(place_).place(), true, status.code()});
  }

  const Json* accessor_of(const Json& holder, const char* name) const {
    const auto index = integer_field(holder, name);
    return index ? top_level_object(document_.json, "accessors", *index) : nullptr;
  }

  bool has_fallback(const Json& primitive) const {
    const auto has_data = [&](const Json& holder, const std::string& name) {
      const Json* accessor = accessor_of(holder, name.c_str());
      return accessor != nullptr && field(*accessor, "bufferView") != nullptr;
    };
    if (!has_data(primitive, "indices")) return false;
    const Json& attributes = *object_field(primitive, "attributes");
    for (const auto& [semantic, index] : attributes.items())
      if (!has_data(attributes, semantic)) return false;
    return true;
  }

  void check_primitive(PrimitiveId id) {
    place_ = place_of(id);
    const Expected<StoredPrimitive> patched = stored_primitive(document_, id, kExtensionName);
    if (!patched) return report("members", patched.status());
    const Expected<PatchContainer> container = open_container(patched->bytes);
    if (!container)
      return report(check_directory(patched->bytes).ok() ? "decode" : "container", container.status());
    const Expected<Mesh> mesh = backend_.decode(*container, patched->requests, pool_);
    if (!mesh) return report("decode", mesh.status());

    check_decoded(json_of(id), patched->requests, *mesh);
    check_streams(*container, patched->requests, *mesh);
  }

  // `mesh` may have more attributes than the patches.
  void check_decoded(const Json& primitive, std::span<const AttributeRequest> requests, const Mesh& mesh) {
    if (integer_field_or(primitive, "mode", 4) != 4)
      report("mode", "patches are triangle lists: mode must be 4");
    is_fallback_whole_ = has_fallback(primitive);
    check_exclusions(primitive, requests);
    const auto is_stored = [&](const std::string& semantic) {
      return std::ranges::any_of(requests, [&](const AttributeRequest& r) { return r.semantic == semantic; });
    };
    const Json& attributes = *object_field(primitive, "attributes");
    for (const auto& [semantic, index] : attributes.items()) {
      if (is_stored(semantic)) continue;
      report("attribute-extra", semantic + " is not in the patches: its accessor must follow their order",
             false);
      check_count(attributes, semantic, semantic, mesh.point_count);
    }
    for (const Attribute& attribute : mesh.attributes) {
      if (!is_stored(attribute.semantic)) continue;
      check_count(attributes, attribute.semantic, attribute.semantic, mesh.point_count);
      check_bounds(*accessor_of(attributes, attribute.semantic.c_str()), attribute, mesh.point_count);
      check_fallback(attributes, attribute.semantic, attribute.values);
    }
    if (const Json* targets = array_field(primitive, "targets"))
      for (const Json& target : *targets)
        for (const auto& [semantic, index] : target.items())
          check_count(target, semantic, "morph target " + semantic, mesh.point_count);
    check_indices(primitive, mesh);
  }

  void check_exclusions(const Json& primitive, std::span<const AttributeRequest> requests) {
    if (extension_field(primitive, kStockExtensionName) != nullptr)
      report("exclusion", std::string("the primitive has ") + kStockExtensionName + " as well");
    const Json& attributes = *object_field(primitive, "attributes");
    const auto check = [&](const Json& holder, const std::string& name) {
      const Json* accessor = accessor_of(holder, name.c_str());
      if (accessor != nullptr && field(*accessor, "sparse") != nullptr)
        report("exclusion", name + " is in the patches, but its accessor is sparse");
    };
    for (const AttributeRequest& request : requests) check(attributes, request.semantic);
    check(primitive, "indices");
    const auto view = integer_field(*extension_field(primitive, kExtensionName), "bufferView");
    if (meshopt_extension(*top_level_object(document_.json, "bufferViews", *view)) != nullptr)
      report("exclusion", "the container's buffer view is compressed");
  }

  // Stream by stream, by the definition of numbering: what decoding the whole container does not compare.
  void check_streams(const PatchContainer& container, std::span<const AttributeRequest> requests,
                     const Mesh& mesh) {
    const size_t count = container.entries.size();
    std::vector<Mesh> streams(count);
    std::vector<Status> decoded(count), typed(count), copied(count);
    pool_.for_each(count, [&](size_t i) {
      Expected<Mesh> stream =
          backend_.decode(container.alone(static_cast<uint32_t>(i)), requests, ThreadPool(1));
      decoded[i] = stream.status();
      if (stream) streams[i] = std::move(*stream);
      streams[i].faces.resize(container.entries[i].face_count);  // without the residue's padding
      typed[i] = check_types(container.streams[i], requests);
    });
    std::vector<std::span<const Face>> faces;
    for (const Mesh& stream : streams) faces.emplace_back(stream.faces);
    const auto bad = std::ranges::find_if(decoded, [](const Status& status) { return !status.ok(); });
    if (bad != decoded.end()) return report("decode", std::move(*bad).at({.patch = bad - decoded.begin()}));
    const auto numbers = number_points(container, faces, pool_);
    if (!numbers) return report("decode", numbers.status());
    pool_.for_each(container.patch_count(),  // copies in the residue hold any value
                   [&](size_t i) { copied[i] = check_copies(streams[i], (*numbers)[i], mesh); });
    for (size_t i = 0; i < count; ++i) {
      const Place place{.patch = static_cast<int64_t>(i)};
      if (!typed[i].ok()) report("attribute-type", std::move(typed[i]).at(place));
      if (!copied[i].ok()) report("copies", std::move(copied[i]).at(place));
    }
  }

  static Status check_types(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests) {
    const Expected<StreamDescription> description = describe_stream(stream);
    if (!description) return description.status();
    for (const AttributeRequest& request : requests)
      for (const StreamAttribute& attribute : description->attributes)
        if (attribute.unique_id == request.unique_id && attribute.type != stored_type(request.component_type))
          return invalid_input(request.semantic + " is stored in another type than its accessor's");
    return {};
  }

  static Status check_copies(const Mesh& stream, const std::vector<uint32_t>& numbers, const Mesh& mesh) {
    for (size_t k = 0; k < mesh.attributes.size(); ++k) {
      const size_t stride = mesh.attributes[k].stride();
      const std::byte* copies = stream.attributes[k].values.data();
      const std::byte* values = mesh.attributes[k].values.data();
      for (size_t point = 0; point < numbers.size(); ++point)
        if (std::memcmp(copies + point * stride, values + numbers[point] * stride, stride) != 0)
          return invalid_input(mesh.attributes[k].semantic + " of decoded point " + std::to_string(point) +
                               " differs from that of point " + std::to_string(numbers[point]) +
                               ", of which it is a copy");
    }
    return {};
  }

  void check_count(const Json& holder, const std::string& name, const std::string& what, uint64_t count) {
    const Json* accessor = accessor_of(holder, name.c_str());
    if (accessor == nullptr) return report("members", what + " has no accessor");
    if (integer_field(*accessor, "count") != static_cast<int64_t>(count))
      report("accessor-count", what + " counts another number than " + std::to_string(count));
  }

  // Nothing to compare where there is no data, or where an extension that is not decoded here holds it.
  void check_fallback(const Json& holder, const std::string& name, std::span<const std::byte> decoded) {
    const Json* accessor = accessor_of(holder, name.c_str());
    if (accessor == nullptr || field(*accessor, "bufferView") == nullptr) return;
    const Expected<AccessorData> data = read_accessor(document_, *integer_field(holder, name.c_str()));
    if (!data && data.status().code() == StatusCode::kUnsupported) return;
    if (!data) return report("fallback", name + ": " + data.status().message(), is_fallback_whole_);
    if (!std::ranges::equal(data->values, decoded))
      report("fallback", name + " has other data than the patches decode to", is_fallback_whole_);
  }

  void check_indices(const Json& primitive, const Mesh& mesh) {
    const Json* indices = accessor_of(primitive, "indices");
    if (indices == nullptr) return report("members", "the primitive has no indices accessor");
    check_count(primitive, "indices", "the accessor of the indices", mesh.faces.size() * 3);
    const std::string* shape = string_field(*indices, "type");
    if (shape == nullptr || *shape != "SCALAR") return report("index-type", "indices are no scalars");
    const auto type = integer_field(*indices, "componentType");
    const uint64_t largest = type == 5121 ? 254 : type == 5123 ? 65534 : type == 5125 ? 4294967294u : 0;
    if (uint64_t{mesh.point_count} > largest + 1)
      return report("index-type",
                    std::to_string(mesh.point_count) + " points do not fit the indices' component type");
    const size_t width = component_bytes(static_cast<ComponentType>(*type));
    Attribute decoded{"indices", static_cast<ComponentType>(*type), 1, false, {}};
    decoded.values.reserve(mesh.faces.size() * 3 * width);
    for (const auto& face : mesh.faces)
      for (const uint32_t point : face) {
        const auto* bytes = reinterpret_cast<const std::byte*>(&point);  // little-endian, as glTF
        decoded.values.insert(decoded.values.end(), bytes, bytes + width);
      }
    check_bounds(*indices, decoded, static_cast<uint32_t>(mesh.faces.size() * 3));
    check_fallback(primitive, "indices", decoded.values);
  }

  void check_bounds(const Json& accessor, const Attribute& attribute, uint32_t count) {
    const bool needs_bounds = attribute.semantic == "POSITION";
    if (!needs_bounds && field(accessor, "min") == nullptr && field(accessor, "max") == nullptr) return;
    Json wanted = Json::object();
    describe_decoded(
        wanted,
        {attribute.component_type, attribute.component_count, attribute.normalized, count, attribute.values},
        true);
    for (const char* name : {"min", "max"}) {
      const Json* stated = array_field(accessor, name);
      const Json& exact = wanted[name];
      bool equal = stated != nullptr && stated->size() == exact.size();
      for (size_t c = 0; equal && c < exact.size(); ++c) {
        const auto a = number_value((*stated)[c]), b = number_value(exact[c]);
        equal = a && b && static_cast<float>(*a) == static_cast<float>(*b);
      }
      if (!equal)
        report("accessor-bounds", attribute.semantic + ": " + name + " is not that of the decoded values");
    }
  }

  const Document& document_;
  const DecodeBackend& backend_;
  const ThreadPool& pool_;
  Place place_;
  bool is_fallback_whole_ = false;  // of the primitive; what stands alone loaders ignore
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> validate_document(const Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool) {
  return Validator(document, backend, pool).run();
}

Status check_readable(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                      const ThreadPool& pool) {
  const Expected<Mesh> mesh = read_primitive(document, id, backend, pool);
  if (!mesh) return mesh.status();
  const Expected<std::vector<MorphAttribute>> morphs = read_morph_targets(document, id, mesh->point_count);
  return morphs.status();
}

Status check_decoded(const Document& document, std::span<const PrimitiveId> ids,
                     std::span<const Mesh* const> meshes, const DecodeBackend& backend,
                     const ThreadPool& pool) {
  for (Finding& finding : Validator(document, backend, pool).run_on_decoded(ids, meshes))
    if (finding.error)
      return {finding.code, finding.message + " [" + finding.rule + "]", std::move(finding.place)};
  return {};
}

Status check_patches(const Document& document, const DecodeBackend& backend, const ThreadPool& pool) {
  std::vector<PrimitiveId> ids;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (kind && kind->storage == PrimitiveStorage::kPatches) ids.push_back(id);
  }
  if (ids.empty()) return {};
  std::vector<const Mesh*> meshes;
  const std::vector<Expected<Mesh>> read = read_primitives(document, ids, backend, pool);
  for (const Expected<Mesh>& mesh : read) {
    if (!mesh) return mesh.status();
    meshes.push_back(&*mesh);
  }
  return check_decoded(document, ids, meshes, backend, pool);
}

}  // namespace psplit
