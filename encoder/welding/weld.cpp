#include "encoder/welding/weld.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace psplit {
namespace {

uint64_t mix(uint64_t value) {
  value ^= value >> 32;
  value *= 0xd6e8feb86659fd93u;
  value ^= value >> 32;
  return value;
}

uint64_t hash_row(const std::byte* row, size_t stride, uint64_t seed) {
  uint64_t hash = mix(seed + 0x9e3779b97f4a7c15u);
  for (size_t at = 0; at < stride; at += 8) {
    uint64_t word = 0;
    std::memcpy(&word, row + at, std::min<size_t>(8, stride - at));
    hash = mix(hash * 0x9e3779b97f4a7c15u + word);
  }
  return hash;
}

size_t position_index(const Mesh& mesh) {
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    if (mesh.attributes[i].semantic == "POSITION") return i;
  return 0;
}

}  // namespace

std::vector<uint32_t> lowest_equal_rows(uint32_t row_count, std::span<const std::byte> bytes, size_t stride,
                                        std::span<const uint32_t> group) {
  constexpr uint32_t kEmpty = 0xffffffffu;
  const size_t mask = std::bit_ceil(size_t{row_count} * 2 + 1) - 1;
  std::vector<uint32_t> table(mask + 1, kEmpty);
  std::vector<uint32_t> lowest(row_count);
  for (uint32_t row = 0; row < row_count; ++row) {
    const std::byte* content = bytes.data() + row * stride;
    size_t slot = hash_row(content, stride, group.empty() ? 0 : group[row]) & mask;
    for (;; slot = (slot + 1) & mask) {
      uint32_t& other = table[slot];
      if (other == kEmpty) other = row;
      const bool same_group = group.empty() || group[other] == group[row];
      if (same_group && std::memcmp(bytes.data() + other * stride, content, stride) == 0) {
        lowest[row] = other;
        break;
      }
    }
  }
  return lowest;
}

std::vector<uint32_t> find_duplicates(const Mesh& mesh, std::span<const std::byte> extra, size_t extra_stride,
                                      const ComparedBytes& compared) {
  std::vector<uint32_t> lowest;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const Attribute& attribute = mesh.attributes[i];
    const Array<std::byte> bytes = compared ? compared(i) : Array<std::byte>();
    lowest = lowest_equal_rows(mesh.point_count, bytes.empty() ? attribute.values : bytes, attribute.stride(),
                               lowest);
    if (std::ranges::adjacent_find(lowest, std::greater_equal()) == lowest.end()) return lowest;  // all differ
  }
  if (extra_stride > 0) lowest = lowest_equal_rows(mesh.point_count, extra, extra_stride, lowest);
  return lowest;
}

WeldedMesh weld(const Mesh& mesh, const ThreadPool& pool) {
  WeldedMesh welded;
  welded.mesh = &mesh;
  const size_t attribute_count = mesh.attributes.size();
  welded.value_of_point.resize(attribute_count);
  const size_t position = position_index(mesh);
  const auto rows = [&](size_t i, std::span<const uint32_t> group) {
    return lowest_equal_rows(mesh.point_count, mesh.attributes[i].values, mesh.attributes[i].stride(), group);
  };
  welded.value_of_point[position] = rows(position, {});
  pool.for_each(attribute_count, [&](size_t i) {
    if (i != position) welded.value_of_point[i] = rows(i, welded.value_of_point[position]);
  });

  std::vector<uint32_t> lowest;
  for (const std::vector<uint32_t>& values : welded.value_of_point)
    lowest = lowest_equal_rows(mesh.point_count, std::as_bytes(std::span(values)), sizeof(uint32_t), lowest);
  std::vector<uint32_t>& last =
      welded.value_of_point[position + 1 == attribute_count ? 0 : attribute_count - 1];
  for (uint32_t point = 0; point < mesh.point_count; ++point)
    if (lowest[point] != point) last[point] = point;
  return welded;
}

void separate_flat_faces(WeldedMesh& welded) {
  std::vector<uint32_t>& vertex = welded.value_of_point[position_index(*welded.mesh)];
  for (const auto& face : welded.mesh->faces)
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t a = face[c], b = face[(c + 1) % 3];
      if (a == b || vertex[a] != vertex[b]) continue;
      // At least one of the two is not the lowest point of its vertex. It can leave alone.
      const uint32_t leaving = vertex[a] == a ? b : a;
      vertex[leaving] = leaving;
    }
}

}  // namespace psplit
