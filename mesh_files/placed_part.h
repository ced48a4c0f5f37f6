// What the writers of mesh files write: primitives at the places where a scene puts them.
#pragma once

#include <cerrno>
#include <cstdio>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "gltf_ext/primitive/mesh_view.h"
#include "mesh_files/origin.h"
#include "mesh_files/triangulate.h"

namespace psplit {

struct PlacedPart {
  std::string object;    // parts of one object follow one another; empty: it has no name
  std::string material;  // its name in the MTL file; empty: none
  MeshView view;         // all indices are below the number of points
  // Moves a position, a normal or a tangent to its place. Empty: the values stay as they are stored.
  std::function<void(std::string_view semantic, std::span<double> value)> place{};
  bool mirrored = false;  // the place is that of a mirror: faces turn round

  size_t face_count() const { return view.indices.count / 3; }
  // Null if there is no such attribute.
  const MeshView::Values* find(std::string_view semantic) const;
  std::array<uint32_t, 3> face(size_t number) const;
  // The value of a point at its place, as floats. The attribute has at most 4 components.
  std::array<float, 4> floats_at(const MeshView::Values& attribute, size_t point) const;
  std::array<double, 4> doubles_at(const MeshView::Values& attribute, size_t point) const;
};

// Whether every part has the attribute, with this number of components.
bool all_have(std::span<const PlacedPart> parts, std::string_view semantic, int component_count);

// Where the positions of the part are, at their places.
PositionSpread position_spread(const PlacedPart& part);
// Whether floats cannot say where the positions of the parts are, at their places.
bool need_doubles(std::span<const PlacedPart> parts);

// Calls visit(first, end) for the points of a part in blocks, and releases the memory of each block of values.
template <typename Visit>
void for_each_block(const PlacedPart& part, const Visit& visit) {
  constexpr size_t kBlock = size_t{1} << 16;  // points
  for (size_t first = 0; first < part.view.point_count; first += kBlock) {
    const size_t end = std::min<size_t>(first + kBlock, part.view.point_count);
    visit(first, end);
    for (const auto& [semantic, values] : part.view.attributes)
      release_mapped({reinterpret_cast<const uint8_t*>(values.at(first)), (end - first) * values.step()});
  }
}

// Buffers writes to a file in blocks. Keeps the first failure.
class FileBuffer {
 public:
  explicit FileBuffer(std::FILE* file) : file_(file) {}

  void text(std::string_view text) { put(text.data(), text.size()); }
  template <typename T>
  void value(const T& value) {
    put(&value, sizeof value);
  }
  void put(const void* bytes, size_t count) {
    bytes_.append(static_cast<const char*>(bytes), count);
    if (bytes_.size() >= kBlock) flush();
  }
  // Whether all was written. If not, errno has the cause.
  bool flush() {
    if (error_ == 0 && std::fwrite(bytes_.data(), 1, bytes_.size(), file_) != bytes_.size()) error_ = errno;
    bytes_.clear();
    if (error_ != 0) errno = error_;
    return error_ == 0;
  }

 private:
  static constexpr size_t kBlock = size_t{1} << 18;
  std::FILE* file_;
  std::string bytes_;
  int error_ = 0;
};

}  // namespace psplit
