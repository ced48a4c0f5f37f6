#include "gltf_ext/validate.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/json_fields.h"
#include "gltf_ext/structure.h"
#include "src/container/container.h"
#include "src/container/stitch.h"
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
// copies            all copies of a point decode to the same bits
// accessor-count    accessors count what is decoded: a value a point, three indices a face
// accessor-bounds   min and max are those of the decoded values
// index-type        indices are scalars of a component type that holds every index
// fallback          accessors with data of their own hold what the patches decode to
// attribute-extra   an attribute of the primitive that the patches do not have (warning)
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

    is_fallback_whole_ = has_fallback(primitive);
    check_exclusions(primitive, patched->requests);
    check_streams(*container, patched->requests, *mesh);
    const Json& attributes = *object_field(primitive, "attributes");
    for (const auto& [semantic, index] : attributes.items()) {
      if (mesh->find(semantic) != nullptr) continue;
      report("attribute-extra", semantic + " is not in the patches: its accessor must follow their order",
             false);
      check_count(attributes, semantic, semantic, mesh->point_count);
    }
    for (const Attribute& attribute : mesh->attributes) {
      check_count(attributes, attribute.semantic, attribute.semantic, mesh->point_count);
      check_bounds(*accessor_of(attributes, attribute.semantic.c_str()), attribute, mesh->point_count);
      check_fallback(attributes, attribute.semantic, attribute.values);
    }
    if (const Json* targets = array_field(primitive, "targets"))
      for (const Json& target : *targets)
        for (const auto& [semantic, index] : target.items())
          check_count(target, semantic, "morph target " + semantic, mesh->point_count);
    check_indices(primitive, *mesh);
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
  void check_streams(const Container& container, std::span<const AttributeRequest> requests, const Mesh& mesh) {
    const size_t count = container.entries.size();
    std::vector<Mesh> streams(count);
    std::vector<Status> decoded(count), typed(count), copied(count);
    pool_.for_each(count, [&](size_t i) {
      Expected<Mesh> stream = backend_.decode_stream(container.streams[i], requests);
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
    pool_.for_each(count, [&](size_t i) { copied[i] = check_copies(streams[i], (*numbers)[i], mesh); });
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

}  // namespace psplit
