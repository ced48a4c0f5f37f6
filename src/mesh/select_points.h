// Some points of a mesh, and which points faces use.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "psplit/mesh.h"

namespace psplit {

// The rows with these numbers, in their order. A row has `width` bytes.
inline Array<std::byte> select_rows(Span<const std::byte> values, size_t width, Span<const uint32_t> rows) {
  Array<std::byte> selected(width * rows.size());
  const auto copy = [&](auto bytes) {
    for (size_t i = 0; i < rows.size(); ++i)
      std::memcpy(selected.data() + i * bytes, values.data() + rows[i] * size_t{bytes}, bytes);
  };
  // Copies of a constant number of bytes are moves, not calls.
  switch (width) {
    case 4: copy(std::integral_constant<size_t, 4>()); break;
    case 8: copy(std::integral_constant<size_t, 8>()); break;
    case 12: copy(std::integral_constant<size_t, 12>()); break;
    case 16: copy(std::integral_constant<size_t, 16>()); break;
    default: copy(width);
  }
  return selected;
}

inline Attribute select_points(const Attribute& attribute, Span<const uint32_t> points) {
  return {attribute.semantic, attribute.component_type, attribute.component_count, attribute.normalized,
          select_rows(attribute.values, attribute.stride(), points)};
}

// A mesh with these points of `mesh`, and without faces.
inline Mesh select_points(const Mesh& mesh, Span<const uint32_t> points) {
  Mesh selected;
  selected.point_count = static_cast<uint32_t>(points.size());
  for (const Attribute& attribute : mesh.attributes)
    selected.attributes.push_back(select_points(attribute, points));
  return selected;
}

// A mesh with these points of `mesh`, and with these faces of it, whose points are all among them.
inline Mesh select_points(const Mesh& mesh, Span<const uint32_t> points, Array<std::array<uint32_t, 3>> faces) {
  Mesh selected = select_points(mesh, points);
  std::vector<uint32_t> number(mesh.point_count);
  for (uint32_t i = 0; i < selected.point_count; ++i) number[points[i]] = i;
  selected.faces = std::move(faces);
  for (auto& face : selected.faces)
    for (uint32_t& point : face) point = number[point];
  return selected;
}

// For each point 1 if a face uses it, otherwise 0.
inline std::vector<uint8_t> used_points(const Mesh& mesh) {
  std::vector<uint8_t> used(mesh.point_count, 0);
  for (const auto& face : mesh.faces)
    for (const uint32_t point : face) used[point] = 1;
  return used;
}

}  // namespace psplit
