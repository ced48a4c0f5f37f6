#include "gltf_ext/validate.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/json_fields.h"
#include "src/container/container.h"

namespace psplit {
namespace {

// rule              what it says
// ----------------  ------------------------------------------------------------------------------------
// extension-used    extensionsUsed lists the extension when a primitive has it
// extension-required  extensionsRequired lists it when a primitive has no fallback
// extension-unused  a list names the extension, but no primitive has it (warning)
// mode              a primitive with patches is a triangle list
// members           bufferView and attributes are there and refer to what exists
// container         header, directory and lengths obey docs/format.md
// decode            every stream decodes to what the directory says, and every reference resolves
// accessor-count    accessors count what is decoded: a value a point, three indices a face
// accessor-bounds   min and max are those of the decoded values
// index-type        the indices' component type holds every index
// attribute-extra   an attribute of the primitive that the patches do not have (warning)

bool lists(const Json& json, const char* list, const char* name) {
  const Json* names = array_field(json, list);
  return names != nullptr && std::find(names->begin(), names->end(), Json(name)) != names->end();
}

class Validator {
 public:
  Validator(const Document& document, const DecodeBackend& backend, const ThreadPool& pool)
      : document_(document), backend_(backend), pool_(pool) {}

  std::vector<Finding> run() {
    bool any = false, any_without_fallback = false;
    for (const PrimitiveId id : all_primitives(document_)) {
      const Json& primitive = document_.json["meshes"][id.mesh]["primitives"][id.primitive];
      const Json* extensions = object_field(primitive, "extensions");
      if (extensions == nullptr || field(*extensions, kExtensionName) == nullptr) continue;
      any = true;
      any_without_fallback |= !has_fallback(primitive);
      check_primitive(id, primitive);
    }
    place_ = {.file = document_.source.string()};
    const bool used = lists(document_.json, "extensionsUsed", kExtensionName);
    const bool required = lists(document_.json, "extensionsRequired", kExtensionName);
    if (any && !used) report("extension-used", "extensionsUsed does not list the extension");
    if (any_without_fallback && !required)
      report("extension-required",
             "a primitive has no fallback, but extensionsRequired does not list the extension");
    if (!any && (used || required))
      report("extension-unused", "the extension is listed, but nothing uses it", false);
    return std::move(findings_);
  }

 private:
  void report(const char* rule, std::string message, bool error = true) {
    findings_.push_back({rule, std::move(message), place_, error});
  }
  void report(const char* rule, const Status& status) {
    findings_.push_back({rule, status.message(), Status(status).at(place_).place(), true});
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

  void check_primitive(PrimitiveId id, const Json& primitive) {
    place_ = {document_.source.string(), static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1};
    if (integer_field_or(primitive, "mode", 4) != 4)
      report("mode", "patches are triangle lists: mode must be 4");
    const Expected<StoredPrimitive> patched = stored_primitive(document_, id, kExtensionName);
    if (!patched) return report("members", patched.status());
    const Expected<Container> container = parse_container(patched->bytes);
    if (!container) return report("container", container.status());
    const Expected<Mesh> mesh = backend_.decode_container(patched->bytes, patched->requests, pool_);
    if (!mesh) return report("decode", mesh.status());

    const Json& attributes = *object_field(primitive, "attributes");
    for (const auto& [semantic, index] : attributes.items()) {
      if (mesh->find(semantic) == nullptr)
        report("attribute-extra", semantic + " is not in the patches: its accessor must follow their order",
               false);
    }
    for (const Attribute& attribute : mesh->attributes)
      check_accessor(*accessor_of(attributes, attribute.semantic.c_str()), attribute, mesh->point_count);
    const Json* indices = accessor_of(primitive, "indices");
    if (indices == nullptr) return report("members", "the primitive has no indices accessor");
    if (integer_field(*indices, "count") != static_cast<int64_t>(mesh->faces.size() * 3))
      report("accessor-count", "indices count another number than " + std::to_string(mesh->faces.size() * 3));
    const auto type = integer_field(*indices, "componentType");
    const uint64_t largest = type == 5121 ? 254 : type == 5123 ? 65534 : type == 5125 ? 4294967294u : 0;
    if (uint64_t{mesh->point_count} > largest + 1)
      report("index-type",
             std::to_string(mesh->point_count) + " points do not fit the indices' component type");
  }

  void check_accessor(const Json& accessor, const Attribute& attribute, uint32_t point_count) {
    if (integer_field(accessor, "count") != point_count)
      report("accessor-count",
             attribute.semantic + " counts another number than " + std::to_string(point_count));
    const bool needs_bounds = attribute.semantic == "POSITION";
    if (!needs_bounds && field(accessor, "min") == nullptr && field(accessor, "max") == nullptr) return;
    Json wanted = Json::object();
    describe_decoded(wanted,
                     {attribute.component_type, attribute.component_count, attribute.normalized, point_count,
                      attribute.values},
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
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> validate_document(const Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool) {
  return Validator(document, backend, pool).run();
}

}  // namespace psplit
