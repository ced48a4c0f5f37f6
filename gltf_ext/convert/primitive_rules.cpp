#include "gltf_ext/convert/primitive_rules.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/convert/stated_bytes.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/files/mapped_file.h"
#include "gltf_ext/json/json_fields.h"
#include "src/container/claims.h"
#include "src/container/patch_container.h"
#include "src/cpu/checked_decode.h"

namespace psplit {
namespace {

// As a whole, the mesh would be in memory together with the copies of points at borders.
bool is_too_large(const PatchContainer& container, std::span<const AttributeRequest> requests,
                  const MemoryLimit& limit) {
  return !limit.allows(decoded_bytes(container, requests) * 3 / 2 + container.bytes.size()) &&
         std::ranges::all_of(requests, is_written_as_stored);
}

class PrimitiveChecker {
 public:
  PrimitiveChecker(const Document& document, PrimitiveId id)
      : document_(document),
        primitive_(document.json["meshes"][id.mesh]["primitives"][id.primitive]),
        place_{document.source.string(), static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1},
        is_fallback_whole_(psplit::has_fallback(document, id)),
        stored_(stored_primitive(document, id, kExtensionName)) {
    if (!stored_) report("members", stored_.status());
  }

  void decode_and_check(const DecodeBackend& backend, const ThreadPool& pool, const MemoryLimit& limit) {
    if (!stored_) return;
    const Expected<PatchContainer> container = open_container(stored_->bytes);
    if (!container)
      return report(check_directory(stored_->bytes).ok() ? "decode" : "container", container.status());
    if (is_too_large(*container, stored_->requests, limit)) return check_in_file(*container, pool, limit);
    Expected<CheckedMesh> checked = decode_checked(*container, stored_->requests, pool);
    if (backend.name != "cpu") {
      Expected<Mesh> mesh = backend.decode(*container, stored_->requests, pool);
      if (!mesh) return report("decode", mesh.status());
      if (checked) checked->mesh = std::move(*mesh);
    }
    if (!checked) return report("decode", checked.status());
    check(view_of(checked->mesh));
    report(checked->streams);
  }

  void check(const MeshView& mesh) {
    if (!stored_) return;
    if (integer_field_or(primitive_, "mode", 4) != 4)
      report("mode", "patches are triangle lists: mode must be 4");
    check_exclusions();
    const auto is_stored = [&](const std::string& semantic) {
      return std::ranges::any_of(stored_->requests,
                                 [&](const AttributeRequest& r) { return r.semantic == semantic; });
    };
    const Json& attributes = *object_field(primitive_, "attributes");
    for (const auto& [semantic, index] : attributes.items()) {
      if (is_stored(semantic)) continue;
      report("attribute-extra", semantic + " is not in the patches: its accessor must follow their order",
             false);
      check_count(attributes, semantic, semantic, mesh.point_count);
    }
    for (const auto& [semantic, values] : mesh.attributes) {
      if (!is_stored(semantic)) continue;
      check_count(attributes, semantic, semantic, mesh.point_count);
      check_bounds(*accessor_of(attributes, semantic.c_str()), semantic, values);
      check_fallback(attributes, semantic, values, values.value_bytes());
    }
    if (const Json* targets = array_field(primitive_, "targets"))
      for (const Json& target : *targets)
        for (const auto& [semantic, index] : target.items())
          check_count(target, semantic, "morph target " + semantic, mesh.point_count);
    check_indices(primitive_, mesh);
  }

  std::vector<Finding> findings() && { return std::move(findings_); }

 private:
  // The mesh is in a temporary file, and is never in memory as a whole.
  void check_in_file(const PatchContainer& container, const ThreadPool& pool, const MemoryLimit& limit) {
    const uint32_t point_count = container.point_count(), face_count = container.face_count();
    Status status = check_results(point_count, face_count, stored_->requests, container.bytes.size());
    if (!status.ok()) return report("decode", status);
    const uint64_t bytes = lay_out(stored_->requests, point_count, face_count, 0, {}).end;
    const Expected<FileMemory> memory = FileMemory::create(limit.folder, bytes);
    if (!memory) return report("decode", memory.status());
    const LaidOutMesh mesh = lay_out(stored_->requests, point_count, face_count, 0, memory->bytes());
    std::vector<StreamFindings> streams(container.entries.size());
    status = decode_to_file(container, stored_->requests, mesh, limit, pool, {}, &streams);
    if (!status.ok()) return report("decode", status);
    check(mesh.view);
    report(streams);
  }

  void report(std::span<const StreamFindings> streams) {
    for (const StreamFindings& stream : streams) {
      if (!stream.types.ok()) report("attribute-type", stream.types);
      if (!stream.copies.ok()) report("copies", stream.copies);
    }
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

  void check_exclusions() {
    if (extension_field(primitive_, kStockExtensionName) != nullptr)
      report("exclusion", std::string("the primitive has ") + kStockExtensionName + " as well");
    const Json& attributes = *object_field(primitive_, "attributes");
    const auto check = [&](const Json& holder, const std::string& name) {
      const Json* accessor = accessor_of(holder, name.c_str());
      if (accessor != nullptr && field(*accessor, "sparse") != nullptr)
        report("exclusion", name + " is in the patches, but its accessor is sparse");
    };
    for (const AttributeRequest& request : stored_->requests) check(attributes, request.semantic);
    check(primitive_, "indices");
    const auto view = integer_field(*extension_field(primitive_, kExtensionName), "bufferView");
    if (meshopt_extension(*top_level_object(document_.json, "bufferViews", *view)) != nullptr)
      report("exclusion", "the container's buffer view is compressed");
  }

  void check_count(const Json& holder, const std::string& name, const std::string& what, uint64_t count) {
    const Json* accessor = accessor_of(holder, name.c_str());
    if (accessor == nullptr) return report("members", what + " has no accessor");
    if (integer_field(*accessor, "count") != static_cast<int64_t>(count))
      report("accessor-count", what + " has another count than " + std::to_string(count));
  }

  // Compares an accessor's own data, if it has data and no unknown extension stores it. An
  // element has `width` bytes: for indices more or fewer than the decoded values.
  void check_fallback(const Json& holder, const std::string& name, const ValuesView& decoded, size_t width) {
    const Json* accessor = accessor_of(holder, name.c_str());
    if (accessor == nullptr || field(*accessor, "bufferView") == nullptr) return;
    const int64_t index = *integer_field(holder, name.c_str());
    Status failure = read_accessor(document_, index, 0, 0).status();
    bool same = integer_field(*accessor, "count") == int64_t{decoded.count};
    const auto is_same = [&](size_t first, size_t end) {
      const Expected<AccessorData> data =
          read_accessor(document_, index, static_cast<uint32_t>(first), static_cast<uint32_t>(end - first));
      failure = data.status();
      if (!data || data->values.size() != (end - first) * width) return false;
      for (size_t i = first; i < end; ++i) {
        uint32_t widened = 0;  // little-endian, as glTF
        if (decoded.value_bytes() < width) std::memcpy(&widened, decoded.at(i), decoded.value_bytes());
        const void* const value =
            decoded.value_bytes() < width ? static_cast<const void*>(&widened) : decoded.at(i);
        if (std::memcmp(data->values.data() + (i - first) * width, value, width) != 0) return false;
      }
      return true;
    };
    if (failure.ok() && same) same = for_each_step(decoded, is_same);
    if (const auto bytes = buffer_view_bytes(document_, integer_field(*accessor, "bufferView").value_or(-1)))
      release_mapped(*bytes);
    if (failure.code() == StatusCode::kUnsupported) return;
    if (!failure.ok()) return report("fallback", name + ": " + failure.message(), is_fallback_whole_);
    if (!same) report("fallback", name + " differs from the decoded data of the patches", is_fallback_whole_);
  }

  void check_indices(const Json& primitive, const MeshView& mesh) {
    const Json* indices = accessor_of(primitive, "indices");
    if (indices == nullptr) return report("members", "the primitive has no indices accessor");
    check_count(primitive, "indices", "the accessor of the indices", mesh.indices.count);
    const std::string* shape = string_field(*indices, "type");
    if (shape == nullptr || *shape != "SCALAR") return report("index-type", "indices are not scalars");
    const auto type = integer_field(*indices, "componentType");
    const uint64_t largest = type == 5121 ? 254 : type == 5123 ? 65534 : type == 5125 ? 4294967294u : 0;
    if (uint64_t{mesh.point_count} > largest + 1)
      return report("index-type",
                    std::to_string(mesh.point_count) + " points do not fit the indices' component type");
    check_bounds(*indices, "indices", mesh.indices);
    check_fallback(primitive, "indices", mesh.indices, component_bytes(static_cast<ComponentType>(*type)));
  }

  void check_bounds(const Json& accessor, const std::string& what, const ValuesView& decoded) {
    const bool needs_bounds = what == "POSITION";
    if (!needs_bounds && field(accessor, "min") == nullptr && field(accessor, "max") == nullptr) return;
    Json wanted = Json::object();
    describe_decoded(wanted, decoded, true);
    for (const char* name : {"min", "max"}) {
      const Json* stated = array_field(accessor, name);
      const Json& exact = wanted[name];
      bool equal = stated != nullptr && stated->size() == exact.size();
      for (size_t c = 0; equal && c < exact.size(); ++c) {
        const auto a = number_value((*stated)[c]), b = number_value(exact[c]);
        equal = a && b && static_cast<float>(*a) == static_cast<float>(*b);
      }
      if (!equal) report("accessor-bounds", what + ": " + name + " is not that of the decoded values");
    }
  }

  const Document& document_;
  const Json& primitive_;
  const Place place_;
  const bool is_fallback_whole_;  // loaders ignore the data of an incomplete fallback
  const Expected<StoredPrimitive> stored_;
  std::vector<Finding> findings_;
};

}  // namespace

bool is_too_large_to_check(const Document& document, PrimitiveId id, const MemoryLimit& limit) {
  const StatedBytes bytes = stated_bytes(document, id);
  return !limit.allows(bytes.decoded * 3 / 2 + bytes.stored);
}

bool has_fallback(const Document& document, PrimitiveId id) {
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  const auto has_data = [&](const Json& holder, const std::string& name) {
    const auto index = integer_field(holder, name.c_str());
    const Json* accessor = index ? top_level_object(document.json, "accessors", *index) : nullptr;
    return accessor != nullptr && field(*accessor, "bufferView") != nullptr;
  };
  if (!has_data(primitive, "indices")) return false;
  const Json& attributes = *object_field(primitive, "attributes");
  for (const auto& [semantic, index] : attributes.items())
    if (!has_data(attributes, semantic)) return false;
  return true;
}

std::vector<Finding> check_patched_primitive(const Document& document, PrimitiveId id,
                                             const DecodeBackend& backend, const ThreadPool& pool,
                                             const MemoryLimit& limit) {
  PrimitiveChecker checker(document, id);
  checker.decode_and_check(backend, pool, limit);
  return std::move(checker).findings();
}

std::vector<Finding> check_decoded_primitive(const Document& document, PrimitiveId id, const MeshView& mesh) {
  PrimitiveChecker checker(document, id);
  checker.check(mesh);
  return std::move(checker).findings();
}

}  // namespace psplit
