#include "encoder/welding/reduce.h"

#include <algorithm>
#include <atomic>
#include <compare>
#include <cstring>
#include <utility>

#include "src/mesh/select_points.h"
#include "src/shared_values.h"

namespace psplit {
namespace {

constexpr size_t kFacesAtOnce = 1 << 14;

// Several threads may set the same flag.
void set_flag(uint8_t& flag) { store_shared(flag, uint8_t{1}); }

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
  ReducedMesh reduced;
  std::vector<uint32_t> lowest;
  if (!options.keep_duplicates) {
    lowest = find_duplicates(input, extra, extra_stride, pool);
    if (options.compared) {
      std::vector<uint32_t> equal = find_duplicates(input, extra, extra_stride, pool, options.compared);
      equal.swap(lowest);
      if (lowest != equal) keep_topology(input, equal, lowest);
    }
    // Points that are equal in all they have are merged.
    reduced.differ_in_positions = input.attributes.size() == 1 && extra_stride == 0;
    if (are_all_lowest(lowest)) lowest = std::vector<uint32_t>();
  }
  const auto representative = [&](uint32_t point) { return lowest.empty() ? point : lowest[point]; };
  const auto is_dropped = [&](const std::array<uint32_t, 3>& merged) {
    return options.drop_degenerate && repeats_a_point(merged);
  };
  std::vector<uint8_t> used(input.point_count, options.drop_unused ? 0 : 1);
  std::vector<size_t> kept_faces((input.faces.size() + kFacesAtOnce - 1) / kFacesAtOnce);  // of each range
  pool.for_ranges(input.faces.size(), kFacesAtOnce, [&](size_t begin, size_t end) {
    size_t kept = 0;
    for (size_t i = begin; i < end; ++i) {
      const auto& [a, b, c] = input.faces[i];
      const std::array<uint32_t, 3> merged = {representative(a), representative(b), representative(c)};
      if (is_dropped(merged)) continue;
      ++kept;
      for (const uint32_t point : merged) set_flag(used[point]);
    }
    kept_faces[begin / kFacesAtOnce] = kept;
  });
  size_t face_count = 0;
  for (size_t& kept : kept_faces)
    face_count += std::exchange(kept, face_count);  // the first face of each range
  reduced.dropped_faces = input.faces.size() - face_count;
  for (uint32_t point = 0; point < input.point_count; ++point) {
    const bool is_merged = representative(point) != point;
    reduced.merged_points += is_merged ? 1 : 0;
    reduced.dropped_points += !is_merged && used[point] == 0 ? 1 : 0;
  }
  if (reduced.is_unchanged() && options.leaves_unchanged) return reduced;

  reduced.source_point.reserve(input.point_count - reduced.merged_points - reduced.dropped_points);
  std::vector<uint32_t> number(input.point_count);  // of each point that a face uses, in the reduced mesh
  for (uint32_t point = 0; point < input.point_count; ++point) {
    const uint32_t lower = representative(point);
    if (lower != point) {
      number[point] = number[lower];
    } else if (used[point] != 0) {
      number[point] = static_cast<uint32_t>(reduced.source_point.size());
      reduced.source_point.push_back(point);
    }
  }
  lowest = std::vector<uint32_t>();
  reduced.mesh = select_points(input, reduced.source_point);
  reduced.mesh.faces.resize(face_count);
  pool.for_ranges(input.faces.size(), kFacesAtOnce, [&](size_t begin, size_t end) {
    auto to = reduced.mesh.faces.begin() + static_cast<std::ptrdiff_t>(kept_faces[begin / kFacesAtOnce]);
    for (size_t i = begin; i < end; ++i) {
      const auto& [a, b, c] = input.faces[i];
      const std::array<uint32_t, 3> numbered = {number[a], number[b], number[c]};
      if (!options.drop_degenerate || !repeats_a_point(numbered)) *to++ = numbered;
    }
  });
  return reduced;
}

std::vector<uint8_t> stored_points(const Mesh& mesh, const ReduceOptions& options, const ThreadPool& pool,
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
  // Points of a face nearly always differ in the first bytes of their positions.
  const Attribute* const positions = mesh.find("POSITION");
  const bool has_words = positions != nullptr && positions->stride() >= sizeof(uint64_t);
  const auto may_merge = [&](const std::array<uint32_t, 3>& face) {
    if (!has_words) return true;
    const auto word = [&](uint32_t point) {
      uint64_t bytes = 0;
      std::memcpy(&bytes, positions->values.data() + point * positions->stride(), sizeof bytes);
      return bytes;
    };
    const uint64_t a = word(face[0]), b = word(face[1]), c = word(face[2]);
    return a == b || b == c || c == a;
  };
  pool.for_ranges(mesh.faces.size(), kFacesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const auto& [a, b, c] = mesh.faces[i];
      if (options.drop_degenerate && may_merge(mesh.faces[i])) {
        const bool merges_points = !options.keep_duplicates && (merges(a, b) || merges(b, c) || merges(c, a));
        if (repeats_a_point(mesh.faces[i]) || merges_points) continue;
      }
      for (const uint32_t point : mesh.faces[i]) set_flag(stored[point]);
    }
  });
  return stored;
}

}  // namespace psplit
