#include "gltf_ext/out_of_core/stream_primitive.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gltf_ext/files/operating_system.h"
#include "gltf_ext/primitive/accessors.h"

namespace psplit {
namespace {

constexpr uint64_t kWindow = uint64_t{1} << 16;  // elements

// The elements of an accessor, tightly packed.
class AccessorWindow {
 public:
  static Expected<AccessorWindow> open(const Document& document, const std::string& name, int64_t index) {
    AccessorWindow window;
    window.accessor_ = &document.records().accessor(index);
    if (window.accessor_->sparse || !window.accessor_->has_view())
      return unsupported(name + ": a sparse accessor does not fit into --memory");
    if (window.layout().stored_bytes() != window.layout().packed_bytes())
      return unsupported(name + ": a matrix with padding does not fit into --memory");
    const Expected<ValuesView> values = accessor_view(document, index);
    if (!values) return values.status();
    window.stride_ = values->step();
    window.bytes_ = {reinterpret_cast<const uint8_t*>(values->bytes.data()), values->bytes.size()};
    return window;
  }

  const ElementLayout& layout() const { return accessor_->layout; }
  bool normalized() const { return accessor_->normalized; }
  uint64_t count() const { return accessor_->count; }

  void read(uint64_t first, size_t count, Array<std::byte>& to) const {
    const size_t width = layout().packed_bytes();
    to.resize(count * width);
    const size_t begin = static_cast<size_t>(first) * stride_;
    for (size_t i = 0; i < count; ++i)
      std::memcpy(to.data() + i * width, bytes_.data() + begin + i * stride_, width);
    release_mapped(bytes_.subspan(begin, (count - 1) * stride_ + width));
  }

 private:
  const AccessorRecord* accessor_ = nullptr;
  size_t stride_ = 0;
  std::span<const uint8_t> bytes_;
};

Status check_attribute(const Attribute& attribute) {
  const std::string& semantic = attribute.semantic;
  if (attribute.component_type == ComponentType::kUint32)
    return unsupported(semantic + " holds 32-bit integers");
  if (semantic == "POSITION" &&
      (attribute.component_type != ComponentType::kFloat32 || attribute.component_count != 3))
    return unsupported("positions that are not floats do not fit into --memory");
  return {};
}

// In memory, positions that are not finite are stored exactly. They belong to no cell.
Status check_positions(int64_t accessor, std::span<const Attribute> block, uint64_t first) {
  const auto position = std::ranges::find(block, "POSITION", &Attribute::semantic);
  if (position == block.end() || position->component_type != ComponentType::kFloat32) return {};
  for (size_t i = 0; i < position->values.size() / sizeof(float); ++i) {
    float value = 0;
    std::memcpy(&value, position->values.data() + i * sizeof(value), sizeof(value));
    if (!std::isfinite(value))
      return invalid_input("accessor " + std::to_string(accessor) + ": the position of point " +
                           std::to_string(first + i / position->component_count) + " is not finite");
  }
  return {};
}

Status stream_points(const Document& document, const PrimitiveRecord& primitive, MeshSink& sink,
                     uint64_t& point_count) {
  std::vector<AccessorWindow> windows;
  std::vector<Attribute> block;
  const int64_t position = primitive.accessor_of("POSITION");
  if (position < 0) return unsupported("no POSITION");
  for (const auto& [semantic, accessor] : primitive.attributes) {
    Expected<AccessorWindow> window = AccessorWindow::open(document, "attribute " + semantic, accessor);
    if (!window) return window.status();
    const ElementLayout& layout = window->layout();
    block.push_back({semantic, layout.component_type, layout.component_count(), window->normalized(), {}});
    if (Status status = check_attribute(block.back()); !status.ok()) return status;
    if (!windows.empty() && window->count() != windows[0].count())
      return invalid_input("attribute " + semantic + " has " + std::to_string(window->count()) +
                           " elements, others have " + std::to_string(windows[0].count()));
    windows.push_back(std::move(*window));
  }
  point_count = windows[0].count();
  if (Status status = sink.begin(block, 0); !status.ok()) return status;
  for (uint64_t first = 0; first < point_count; first += kWindow) {
    const auto count = static_cast<size_t>(std::min(kWindow, point_count - first));
    for (size_t i = 0; i < block.size(); ++i) windows[i].read(first, count, block[i].values);
    if (Status status = check_positions(position, block, first); !status.ok()) return status;
    if (Status status = sink.add_points(block, count); !status.ok()) return status;
  }
  return {};
}

// Consecutive indices, where the corners of a face never are in two windows.
class Indices {
 public:
  static Expected<Indices> open(const Document& document, const PrimitiveRecord& primitive,
                                uint64_t point_count) {
    Indices indices;
    indices.point_count_ = indices.count_ = point_count;
    if (primitive.indices >= 0) {
      Expected<AccessorWindow> window = AccessorWindow::open(document, "indices", primitive.indices);
      if (!window) return window.status();
      const ComponentType type = window->layout().component_type;
      if (window->layout().component_count() != 1 ||
          (type != ComponentType::kUint8 && type != ComponentType::kUint16 && type != ComponentType::kUint32))
        return invalid_input("indices are not unsigned scalars");
      indices.count_ = window->count();
      indices.window_ = std::move(*window);
    }
    if (indices.count_ % 3 != 0)
      return invalid_input("a triangle list has " + std::to_string(indices.count_) + " indices");
    return indices;
  }

  uint64_t face_count() const { return count_ / 3; }

  Status read(uint64_t first_face, size_t face_count, std::vector<std::array<uint32_t, 3>>& faces) {
    faces.resize(face_count);
    if (window_) window_->read(3 * first_face, 3 * face_count, values_);
    const size_t width = window_ ? window_->layout().packed_bytes() : 0;
    const uint32_t restart = width == 4 ? UINT32_MAX : (1u << 8 * width) - 1;
    for (size_t i = 0; i < 3 * face_count; ++i) {
      const uint64_t number = 3 * first_face + i;
      uint32_t index = static_cast<uint32_t>(number);
      if (window_) {
        index = 0;
        std::memcpy(&index, values_.data() + i * width, width);
        if (index == restart)
          return invalid_input("index " + std::to_string(number) + " is " + std::to_string(restart) +
                               ", which restarts primitives and glTF forbids");
      }
      if (index >= point_count_)
        return invalid_input("index " + std::to_string(number) + " is " + std::to_string(index) +
                             ", but there are " + std::to_string(point_count_) + " points");
      faces[i / 3][i % 3] = index;
    }
    return {};
  }

 private:
  uint64_t point_count_ = 0, count_ = 0;
  std::optional<AccessorWindow> window_;  // nothing: 0, 1, 2 ...
  Array<std::byte> values_;
};

}  // namespace

PrimitiveSize stated_size(const Document& document, PrimitiveId id) {
  const AssetRecords& records = document.records();
  const PrimitiveRecord& primitive = records.primitive(id);
  PrimitiveSize size{records.points_of(primitive), records.faces_of(primitive)};
  for (const AttributeRecord& attribute : primitive.attributes)
    size.record_bytes += records.accessor(attribute.accessor).layout.packed_bytes();
  return size;
}

Status stream_primitive(const Document& document, PrimitiveId id, MeshSink& sink) {
  const PrimitiveRecord& primitive = document.records().primitive(id);
  if (!primitive.status.ok()) return primitive.status;
  if (primitive.storage() != PrimitiveStorage::kPlain)
    return unsupported("a compressed primitive does not fit into --memory");
  if (primitive.mode != 4) return unsupported("a triangle strip or fan does not fit into --memory");
  if (!primitive.targets.empty()) return unsupported("morph targets do not fit into --memory");
  uint64_t point_count = 0;
  if (Status status = stream_points(document, primitive, sink, point_count); !status.ok()) return status;
  Expected<Indices> indices = Indices::open(document, primitive, point_count);
  if (!indices) return indices.status();
  std::vector<std::array<uint32_t, 3>> faces;
  for (uint64_t first = 0; first < indices->face_count(); first += kWindow) {
    const auto count = static_cast<size_t>(std::min(kWindow, indices->face_count() - first));
    if (Status status = indices->read(first, count, faces); !status.ok()) return status;
    if (Status status = sink.add_faces(faces); !status.ok()) return status;
  }
  return {};
}

}  // namespace psplit
