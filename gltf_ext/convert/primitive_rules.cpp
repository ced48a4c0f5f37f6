#include <algorithm>
#include <cstring>

#include "gltf_ext/convert/check_values.h"
#include "gltf_ext/convert/decode_to_file.h"
#include "gltf_ext/convert/stated_bytes.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "src/container/patch_boxes.h"
#include "src/container/patch_container.h"
#include "src/cpu/checked_decode.h"
#include "system/operating_system.h"

namespace psplit {
namespace {

std::string describe_miss(const PatchBox& box, const PatchBox& positions, size_t axis) {
  const auto range = [axis](const PatchBox& of) {
    return Json(of.low[axis]).dump() + " to " + Json(of.high[axis]).dump();
  };
  return std::string("its ") + "xyz"[axis] + " is from " + range(positions) + ", but " +
         (box.low[axis] > box.high[axis] ? "its box is empty" : "in its box from " + range(box));
}

class PrimitiveChecker {
 public:
  PrimitiveChecker(const Document& document, PrimitiveId id)
      : document_(document),
        id_(id),
        records_(document.records()),
        primitive_(records_.primitive(id)),
        place_(place_of(document, id)),
        is_fallback_whole_(records_.has_plain_data(primitive_)),
        stored_(stored_primitive(document, id)) {
    if (!stored_) report("members", stored_.status());
  }

  void decode_and_check(const DecodeBackend& backend, const ThreadPool& pool, const MemoryLimit& limit,
                        ValueWarnings warnings) {
    if (!stored_) return;
    const Expected<PatchContainer> container = open_container(stored_->bytes);
    if (!container)
      return report(check_directory(stored_->bytes).ok() ? "decode" : "container", container.status());
    if (must_be_in_file(*container, limit)) return check_in_file(*container, pool, limit, warnings);
    Expected<CheckedMesh> checked = decode_checked(*container, stored_->requests, pool);
    if (backend.name != "cpu") {
      Expected<Mesh> mesh = backend.decode(*container, stored_->requests, pool);
      if (!mesh) return report("decode", mesh.status());
      if (checked) checked->mesh = std::move(*mesh);
    }
    if (!checked) return report("decode", checked.status());
    const MeshView mesh = view_of(checked->mesh);
    check(mesh);
    report(checked->streams);
    check_boxes(*container, mesh, pool);
    if (warnings == ValueWarnings::kAll) warn_of_values(mesh);
  }

  void check(const MeshView& mesh) {
    if (!stored_) return;
    if (primitive_.mode != 4) report("mode", "patches are triangle lists: mode must be 4");
    check_exclusions();
    for (const auto& [semantic, accessor] : primitive_.attributes) {
      if (primitive_.patches->stores(semantic)) continue;
      report("attribute-extra", semantic + " is not in the patches: its accessor must follow their order",
             false);
      check_count(accessor, semantic, mesh.point_count);
    }
    for (const auto& [semantic, values] : mesh.attributes) {
      if (!primitive_.patches->stores(semantic)) continue;
      const int64_t accessor = primitive_.accessor_of(semantic);
      check_count(accessor, semantic, mesh.point_count);
      check_bounds(accessor, semantic, values);
      check_fallback(accessor, semantic, values, values.value_bytes());
    }
    for (size_t t = 0; t < primitive_.targets.size(); ++t)
      for (const auto& [semantic, accessor] : primitive_.targets[t])
        if (const std::string name = name_of_target(t, semantic); !primitive_.patches->stores(name))
          check_count(accessor, name, mesh.point_count);
    check_indices(mesh);
  }

  void report(std::span<const StreamFindings> streams) {
    for (const StreamFindings& stream : streams) {
      if (!stream.types.ok()) report("attribute-type", stream.types);
      if (!stream.copies.ok()) report("copies", stream.copies);
    }
  }

  std::vector<Finding> findings() && { return std::move(findings_); }

 private:
  bool must_be_in_file(const PatchContainer& container, const MemoryLimit& limit) const {
    const uint64_t decoded =
        lay_out(stored_->requests, container.point_count(), container.face_count(), 0, {}).end;
    return !StatedBytes{container.bytes.size(), decoded}.fit_into(limit) &&
           std::ranges::all_of(stored_->requests, is_written_as_stored);
  }

  // The mesh is in a temporary file, and is never in memory as a whole.
  void check_in_file(const PatchContainer& container, const ThreadPool& pool, const MemoryLimit& limit,
                     ValueWarnings warnings) {
    std::vector<StreamFindings> streams(container.entries.size());
    const Expected<MeshInFile> mesh = decode_to_file(container, stored_->requests, limit, pool, &streams);
    if (!mesh) return report("decode", mesh.status());
    check(mesh->laid_out.view);
    report(streams);
    check_boxes(container, mesh->laid_out.view, pool);
    if (warnings == ValueWarnings::kAll) warn_of_values(mesh->laid_out.view);
  }

  void warn_of_values(const MeshView& mesh) {
    std::ranges::move(check_values(document_, id_, mesh), std::back_inserter(findings_));
  }

  void check_boxes(const PatchContainer& container, const MeshView& mesh, const ThreadPool& pool) {
    const Expected<std::vector<PatchBox>> boxes = patch_boxes(container);
    if (!boxes) return report_box(boxes.status());
    const ValuesView* const positions = mesh.find("POSITION");
    if (boxes->empty() || positions == nullptr) return;
    if (positions->component_count != 3) return report_box(invalid_input("boxes of patches without positions"));
    // The mesh may be in a mapped file: each step frees the memory that it has read.
    constexpr uint32_t kStepFaces = 1 << 20;
    const auto count = static_cast<uint32_t>(boxes->size());
    std::vector<PatchBox> wanted(count);
    for (uint32_t first = 0, end = 0; first < count; first = end) {
      const uint32_t faces = container.face_base[first];
      while (end < count && (end == first || container.face_base[end + 1] - faces <= kStepFaces)) ++end;
      pool.for_each(end - first, [&](size_t i) {
        const auto stream = static_cast<uint32_t>(first + i);
        wanted[stream] = box_of(
            place_of_stream(container, stream), positions->component_type, positions->normalized,
            [&](size_t corner) { return mesh.index(corner); },
            [&](uint32_t point) { return positions->at(point); });
      });
      for (const ValuesView* values : {positions, &mesh.indices})
        release_mapped({reinterpret_cast<const uint8_t*>(values->bytes.data()), values->bytes.size()});
    }
    for (uint32_t i = 0; i < count; ++i)
      if (const std::optional<size_t> axis = axis_outside((*boxes)[i], wanted[i]))
        report_box(invalid_input(describe_miss((*boxes)[i], wanted[i], *axis), {.patch = i}));
  }

  // No mesh is wrong because of a box, so no reader refuses it.
  void report_box(const Status& status) {
    report("boxes", status);
    findings_.back().only_validated = true;
  }
  void report(const char* rule, std::string message, bool error = true) {
    findings_.push_back({rule, std::move(message), place_, error});
  }
  void report(const char* rule, const Status& status) {
    findings_.push_back({rule, status.message(), Status(status).at(place_).place(), true, status.code()});
  }

  void check_exclusions() {
    if (primitive_.stock)
      report("exclusion", std::string("the primitive has ") + kStockExtensionName + " as well");
    const auto check = [&](int64_t accessor, const std::string& name) {
      if (accessor >= 0 && records_.accessor(accessor).sparse)
        report("exclusion", name + " is in the patches, but its accessor is sparse");
    };
    for (const AttributeRequest& request : stored_->requests)
      check(primitive_.accessor_of(request.semantic), request.semantic);
    check(primitive_.indices, "indices");
    if (records_.view(primitive_.patches->view).meshopt)
      report("exclusion", "the container's buffer view is compressed");
  }

  void check_count(int64_t accessor, const std::string& what, uint64_t count) {
    if (records_.accessor(accessor).count != count)
      report("accessor-count", what + " has another count than " + std::to_string(count));
  }

  // Compares an accessor's own data, if it has data and no unknown extension stores it. An
  // element has `width` bytes: for indices more or fewer than the decoded values.
  void check_fallback(int64_t index, const std::string& name, const ValuesView& decoded, size_t width) {
    const AccessorRecord& accessor = records_.accessor(index);
    if (!accessor.has_view()) return;
    Status failure = read_accessor(document_, index, 0, 0).status();
    bool same = accessor.count == decoded.count;
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
    if (const auto bytes = buffer_view_bytes(document_, accessor.elements.view)) release_mapped(*bytes);
    if (failure.code() == StatusCode::kUnsupported) return;
    if (!failure.ok()) return report("fallback", name + ": " + failure.message(), is_fallback_whole_);
    if (!same) report("fallback", name + " differs from the decoded data of the patches", is_fallback_whole_);
  }

  void check_indices(const MeshView& mesh) {
    if (primitive_.indices < 0) return report("members", "the primitive has no indices accessor");
    const AccessorRecord& indices = records_.accessor(primitive_.indices);
    check_count(primitive_.indices, "the accessor of the indices", mesh.indices.count);
    if (indices.layout.component_count() != 1) return report("index-type", "indices are not scalars");
    const ComponentType type = indices.layout.component_type;
    const uint64_t largest = type == ComponentType::kUint8    ? 254
                             : type == ComponentType::kUint16 ? 65534
                             : type == ComponentType::kUint32 ? 4294967294u
                                                              : 0;
    if (uint64_t{mesh.point_count} > largest + 1)
      return report("index-type",
                    std::to_string(mesh.point_count) + " points do not fit the indices' component type");
    check_bounds(primitive_.indices, "indices", mesh.indices);
    check_fallback(primitive_.indices, "indices", mesh.indices, component_bytes(type));
  }

  void check_bounds(int64_t index, const std::string& what, const ValuesView& decoded) {
    const Json& accessor = document_.json()["accessors"][static_cast<size_t>(index)];
    const bool needs_bounds = what == "POSITION";
    if (!needs_bounds && field(accessor, "min") == nullptr && field(accessor, "max") == nullptr) return;
    Json wanted = Json::object();
    describe_decoded(wanted, decoded, true);
    for (const char* name : {"min", "max"})
      if (!is_bound(field(accessor, name), wanted[name]))
        report("accessor-bounds", what + ": " + name + " differs from that of the decoded values");
  }

  const Document& document_;
  const PrimitiveId id_;
  const AssetRecords& records_;
  const PrimitiveRecord& primitive_;
  const Place place_;
  const bool is_fallback_whole_;  // loaders ignore the data of an incomplete fallback
  const Expected<StoredPrimitive> stored_;
  std::vector<Finding> findings_;
};

}  // namespace

bool is_too_large_to_check(const Document& document, PrimitiveId id, const MemoryLimit& limit) {
  return !stated_bytes(document, id).fit_into(limit);
}

std::vector<Finding> check_patched_primitive(const Document& document, PrimitiveId id,
                                             const DecodeBackend& backend, const ThreadPool& pool,
                                             const MemoryLimit& limit, ValueWarnings warnings) {
  PrimitiveChecker checker(document, id);
  checker.decode_and_check(backend, pool, limit, warnings);
  return std::move(checker).findings();
}

std::vector<Finding> check_decoded_primitive(const Document& document, PrimitiveId id, const MeshView& mesh,
                                             std::span<const StreamFindings> streams) {
  PrimitiveChecker checker(document, id);
  checker.check(mesh);
  checker.report(streams);
  return std::move(checker).findings();
}

}  // namespace psplit
