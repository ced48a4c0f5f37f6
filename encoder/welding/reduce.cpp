#include "encoder/welding/reduce.h"

#include <algorithm>
#include <compare>
#include <cstring>
#include <utility>

#include "src/mesh/select_points.h"

namespace psplit {
namespace {

// Removes the groups of `alike` that would change the topology of the mesh whose groups of `equal` are merged.
void keep_topology(const Mesh& mesh, const std::vector<uint32_t>& equal, std::vector<uint32_t>& alike) {
  std::vector<uint8_t> is_kept_apart(mesh.point_count, 0);
  struct Side {
    uint32_t low, high;
    bool is_merged;
    auto operator<=>(const Side&) const = default;
  };
  std::vector<Side> sides;
  for (const auto& face : mesh.faces) {
    const std::array<uint32_t, 3> before{equal[face[0]], equal[face[1]], equal[face[2]]};
    if (repeats_a_point(before)) continue;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t a = alike[face[c]], b = alike[face[(c + 1) % 3]];
      if (a == b) is_kept_apart[a] = 1;
      sides.push_back({std::min(a, b), std::max(a, b), before[c] != a || before[(c + 1) % 3] != b});
    }
  }
  std::ranges::sort(sides);
  for (size_t i = 0, end = 0; i < sides.size(); i = end) {
    bool is_merged = false;
    for (end = i; end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high;
         ++end)
      is_merged |= sides[end].is_merged;
    if (is_merged && end - i > 2) is_kept_apart[sides[i].low] = is_kept_apart[sides[i].high] = 1;
  }
  for (uint32_t point = 0; point < mesh.point_count; ++point)
    if (is_kept_apart[alike[point]] != 0) alike[point] = equal[point];
}

}  // namespace

ReducedMesh reduce(const Mesh& input, const ReduceOptions& options, const ThreadPool& pool,
                   std::span<const std::byte> extra, size_t extra_stride) {
  std::vector<uint32_t> lowest;
  if (!options.keep_duplicates) {
    lowest = find_duplicates(input, extra, extra_stride, pool);
    if (options.compared) {
      std::vector<uint32_t> equal = find_duplicates(input, extra, extra_stride, pool, options.compared);
      equal.swap(lowest);
      if (lowest != equal) keep_topology(input, equal, lowest);
    }
  }
  const auto representative = [&](uint32_t point) { return lowest.empty() ? point : lowest[point]; };

  ReducedMesh reduced;
  Array<std::array<uint32_t, 3>> faces;
  faces.reserve(input.faces.size());
  std::vector<uint8_t> used(input.point_count, options.drop_unused ? 0 : 1);
  for (const auto& face : input.faces) {
    const std::array<uint32_t, 3> merged = {representative(face[0]), representative(face[1]),
                                            representative(face[2])};
    if (options.drop_degenerate && repeats_a_point(merged)) {
      ++reduced.dropped_faces;
      continue;
    }
    for (const uint32_t point : merged) used[point] = 1;
    faces.push_back(merged);
  }

  for (uint32_t point = 0; point < input.point_count; ++point) {
    if (representative(point) != point)
      ++reduced.merged_points;
    else if (!used[point])
      ++reduced.dropped_points;
    else
      reduced.source_point.push_back(point);
  }
  reduced.mesh = select_points(input, reduced.source_point, std::move(faces));
  return reduced;
}

std::vector<uint8_t> stored_points(const Mesh& mesh, const ReduceOptions& options,
                                   std::span<const std::byte> extra, size_t extra_stride) {
  std::vector<uint8_t> stored(mesh.point_count, options.drop_unused ? 0 : 1);
  if (!options.drop_unused) return stored;
  const auto rows_equal = [](const auto& bytes, size_t stride, uint32_t a, uint32_t b) {
    return std::memcmp(bytes.data() + a * stride, bytes.data() + b * stride, stride) == 0;
  };
  const auto merges = [&](uint32_t a, uint32_t b) {
    return std::ranges::all_of(mesh.attributes,
                               [&](const Attribute& attribute) {
                                 return rows_equal(attribute.values, attribute.stride(), a, b);
                               }) &&
           (extra_stride == 0 || rows_equal(extra, extra_stride, a, b));
  };
  for (const auto& face : mesh.faces) {
    const auto& [a, b, c] = face;
    if (stored[a] != 0 && stored[b] != 0 && stored[c] != 0) continue;
    const bool merges_points = !options.keep_duplicates && (merges(a, b) || merges(b, c) || merges(c, a));
    if (options.drop_degenerate && (repeats_a_point(face) || merges_points)) continue;
    for (const uint32_t point : face) stored[point] = 1;
  }
  return stored;
}

}  // namespace psplit
