#include "gltf_ext/compare/triangle_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

#include "gltf_ext/files/operating_system.h"

namespace psplit {
namespace {

constexpr size_t kFacesOfATask = size_t{1} << 15;
constexpr size_t kFacesOfARound = size_t{1} << 20;  // memory is released after each

// The values of one point, as they are hashed.
void write_point(std::span<const ValuesView> columns, uint32_t point, uint8_t* to) {
  for (const ValuesView& column : columns) {
    const size_t bytes = column.value_bytes();
    const std::byte* from = column.at(point);
    if (column.component_type != ComponentType::kFloat32) {
      std::memcpy(to, from, bytes);
    } else {
      for (size_t c = 0; c < column.component_count; ++c) {
        float value;
        std::memcpy(&value, from + c * sizeof(value), sizeof(value));
        if (value == 0) value = 0;  // without a sign
        std::memcpy(to + c * sizeof(value), &value, sizeof(value));
      }
    }
    to += bytes;
  }
}

uint32_t index_at(const ValuesView& indices, size_t at) {
  uint32_t index = 0;  // little-endian, as glTF and every host of this library
  std::memcpy(&index, indices.at(at), indices.value_bytes());
  return index;
}

size_t cell_of(const uint8_t* record, const PositionBox& box) {
  constexpr auto kLast = static_cast<float>(TriangleSums::kCells - 1);
  size_t cell = 0;
  for (size_t axis = 3; axis-- > 0;) {
    float value;
    std::memcpy(&value, record + axis * sizeof(value), sizeof(value));
    const float share = (value - box.low[axis]) / (box.high[axis] - box.low[axis]);
    const float place = share > 0 ? std::min(share * TriangleSums::kCells, kLast) : 0;  // 0 for NaN
    cell = cell * TriangleSums::kCells + static_cast<size_t>(place);
  }
  return cell;
}

// Adds faces [first, end). False if an index is invalid.
bool add_faces(const MeshView& mesh, std::span<const ValuesView> columns, size_t first, size_t end,
               const PositionBox& box, TriangleSums& sums) {
  size_t size = 0;
  for (const ValuesView& column : columns) size += column.value_bytes();
  std::vector<uint8_t> corners(3 * size), turned(3 * size);
  constexpr size_t kPositionBytes = 3 * sizeof(float);
  for (size_t face = first; face < end; ++face) {
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t point = index_at(mesh.indices, 3 * face + c);
      if (point >= mesh.point_count) return false;
      write_point(columns, point, corners.data() + c * size);
    }
    const auto compare = [&](size_t a, size_t b, size_t bytes) {
      return std::memcmp(corners.data() + a * size, corners.data() + b * size, bytes);
    };
    if (compare(0, 1, kPositionBytes) == 0 || compare(1, 2, kPositionBytes) == 0 ||
        compare(2, 0, kPositionBytes) == 0) {
      ++sums.degenerate;
      continue;
    }
    size_t least = compare(1, 0, size) < 0 ? 1 : 0;
    if (compare(2, least, size) < 0) least = 2;
    const size_t before = least * size;
    std::memcpy(turned.data(), corners.data() + before, 3 * size - before);
    std::memcpy(turned.data() + 3 * size - before, corners.data(), before);
    const Hash128 hash = hash_of({reinterpret_cast<const char*>(turned.data()), turned.size()});
    sums.all.add(hash);
    sums.cells[cell_of(turned.data(), box)].add(hash);
  }
  return true;
}

void release(const ValuesView& values) {
  release_mapped({reinterpret_cast<const uint8_t*>(values.bytes.data()), values.bytes.size()});
}

}  // namespace

void TriangleSum::add(const Hash128& hash) {
  low += hash.low;
  high += hash.high + (low < hash.low ? 1 : 0);
  ++count;
}

void TriangleSum::add(const TriangleSum& other) {
  low += other.low;
  high += other.high + (low < other.low ? 1 : 0);
  count += other.count;
}

Expected<TriangleSums> sum_triangles(std::span<const MeshView> meshes, std::span<const std::string> attributes,
                                     const PositionBox& box, const ThreadPool& pool) {
  TriangleSums total;
  std::mutex mutex;
  bool is_valid = true;
  for (const MeshView& mesh : meshes) {
    std::vector<ValuesView> columns;
    for (const std::string& semantic : attributes)
      columns.push_back(std::ranges::find(mesh.attributes, semantic, &MeshView::Values::semantic)->values);
    const size_t face_count = mesh.indices.count / 3;
    for (size_t round = 0; round < face_count && is_valid; round += kFacesOfARound) {
      const size_t end = std::min(round + kFacesOfARound, face_count);
      pool.for_each((end - round + kFacesOfATask - 1) / kFacesOfATask, [&](size_t task) {
        const size_t first = round + task * kFacesOfATask;
        TriangleSums sums;
        const bool valid = add_faces(mesh, columns, first, std::min(first + kFacesOfATask, end), box, sums);
        const std::lock_guard lock(mutex);
        is_valid &= valid;
        total.all.add(sums.all);
        for (size_t i = 0; i < sums.cells.size(); ++i) total.cells[i].add(sums.cells[i]);
        total.degenerate += sums.degenerate;
      });
      for (const ValuesView& column : columns) release(column);
      release(mesh.indices);
    }
  }
  if (!is_valid) return invalid_input("an index is not below the number of points");
  return total;
}

PositionBox position_box(std::span<const MeshView> meshes) {
  PositionBox box;
  box.low.fill(std::numeric_limits<float>::max());
  box.high.fill(std::numeric_limits<float>::lowest());
  for (const MeshView& mesh : meshes) {
    const auto position = std::ranges::find(mesh.attributes, "POSITION", &MeshView::Values::semantic);
    if (position == mesh.attributes.end()) continue;
    for_each_step(position->values, [&](size_t first, size_t end) {
      for (size_t i = first; i < end; ++i)
        for (size_t axis = 0; axis < 3; ++axis) {
          float value;
          std::memcpy(&value, position->values.at(i) + axis * sizeof(value), sizeof(value));
          if (!std::isfinite(value)) continue;
          box.low[axis] = std::min(box.low[axis], value);
          box.high[axis] = std::max(box.high[axis], value);
        }
      return true;
    });
  }
  return box;
}

}  // namespace psplit
