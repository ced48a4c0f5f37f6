#include "encoder/welding/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>

#include "src/core/platform.h"

namespace psplit {
namespace {

uint64_t mix(uint64_t value) {
  value ^= value >> 32;
  value *= 0xd6e8feb86659fd93u;
  value ^= value >> 32;
  return value;
}

uint32_t hash_row(const std::byte* row, size_t stride, uint64_t seed) {
  uint64_t hash = seed + 0x9e3779b97f4a7c15u;
  const auto add = [&](uint64_t word) { hash = mix(hash * 0x9e3779b97f4a7c15u + word); };
  const auto add_next = [&](auto word) {
    std::memcpy(&word, row, sizeof word);
    add(word);
    row += sizeof word;
    stride -= sizeof word;
  };
  while (stride >= sizeof(uint64_t)) add_next(uint64_t{});
  if (stride >= sizeof(uint32_t)) add_next(uint32_t{});
  while (stride > 0) add_next(uint8_t{});
  return static_cast<uint32_t>(hash ^ hash >> 32);
}

// Rows in a hash table that finds the lowest of equal rows.
class RowTable {
 public:
  RowTable(std::span<const std::byte> bytes, size_t stride, std::span<const uint32_t> group,
           std::span<const uint32_t> hashes, size_t row_count)
      : bytes_(bytes),
        stride_(stride),
        group_(group),
        hashes_(hashes),
        slots_(std::bit_ceil(row_count * 2 + 1), kEmpty) {}

  // Rows come in ascending order. `visit(row, lowest)` may be called later, but by finish() at the latest.
  template <typename Visit>
  void add(uint32_t row, Visit visit) {
    PSPLIT_PREFETCH(&slots_[first_slot(row)]);
    waiting_[waiting_count_++] = row;
    if (waiting_count_ == kWaiting) finish(visit);
  }
  template <typename Visit>
  void finish(Visit visit) {
    for (size_t i = 0; i < waiting_count_; ++i) visit(waiting_[i], find_or_add(waiting_[i]));
    waiting_count_ = 0;
  }

 private:
  static constexpr uint32_t kEmpty = 0xffffffffu;
  // A slot is read when the memory had time to provide it.
  static constexpr size_t kWaiting = 16;

  size_t first_slot(uint32_t row) const { return hashes_[row] & (slots_.size() - 1); }

  uint32_t find_or_add(uint32_t row) {
    const std::byte* const content = bytes_.data() + row * stride_;
    for (size_t slot = first_slot(row);; slot = (slot + 1) & (slots_.size() - 1)) {
      uint32_t& other = slots_[slot];
      if (other == kEmpty) other = row;
      if (other == row) return row;
      if (hashes_[other] == hashes_[row] && (group_.empty() || group_[other] == group_[row]) &&
          std::memcmp(bytes_.data() + other * stride_, content, stride_) == 0)
        return other;
    }
  }

  const std::span<const std::byte> bytes_;
  const size_t stride_;
  const std::span<const uint32_t> group_, hashes_;
  std::vector<uint32_t> slots_;
  std::array<uint32_t, kWaiting> waiting_{};
  size_t waiting_count_ = 0;
};

size_t position_index(const Mesh& mesh) {
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    if (mesh.attributes[i].semantic == "POSITION") return i;
  return 0;
}

// The points that equal a lower point in every attribute.
std::vector<uint32_t> full_duplicates(const WeldedMesh& welded, std::span<const uint32_t> vertex,
                                      const ThreadPool& pool) {
  // A point that has the lowest number of a value has no lower duplicate.
  const auto is_new = [&](uint32_t point) {
    return std::ranges::any_of(welded.value_of_point,
                               [&](const auto& values) { return values[point] == point; });
  };
  std::vector<uint8_t> is_suspect(vertex.size(), 0);  // by vertices
  for (uint32_t point = 0; point < vertex.size(); ++point)
    if (!is_new(point)) is_suspect[vertex[point]] = 1;
  std::vector<uint32_t> points, values;
  for (uint32_t point = 0; point < vertex.size(); ++point) {
    if (is_suspect[vertex[point]] == 0) continue;
    points.push_back(point);
    for (const std::vector<uint32_t>& value_of_point : welded.value_of_point)
      values.push_back(value_of_point[point]);
  }
  const std::vector<uint32_t> lowest =
      lowest_equal_rows(static_cast<uint32_t>(points.size()), std::as_bytes(std::span(values)),
                        welded.value_of_point.size() * sizeof(uint32_t), {}, pool);
  std::vector<uint32_t> duplicates;
  for (uint32_t i = 0; i < points.size(); ++i)
    if (lowest[i] != i) duplicates.push_back(points[i]);
  return duplicates;
}

// Targets have the seams of POSITION, of which there are none, or of the first attribute that has theirs.
std::vector<size_t> find_seams_of(const WeldedMesh& welded, size_t position) {
  const Mesh& mesh = *welded.mesh;
  const auto changes_only_with = [&](size_t target, size_t other) {
    const std::vector<uint32_t>&values = welded.value_of_point[target], &others = welded.value_of_point[other];
    for (uint32_t point = 0; point < mesh.point_count; ++point)
      if (values[point] != values[others[point]]) return false;
    return true;
  };
  std::vector<size_t> seams_of(mesh.attributes.size()), candidates = {position};
  for (size_t i = 0; i < seams_of.size(); ++i) {
    seams_of[i] = i;
    if (i != position && !target_of(mesh.attributes[i].semantic)) candidates.push_back(i);
  }
  for (size_t i = 0; i < seams_of.size(); ++i) {
    if (!target_of(mesh.attributes[i].semantic)) continue;
    const auto found =
        std::ranges::find_if(candidates, [&](size_t other) { return changes_only_with(i, other); });
    if (found != candidates.end())
      seams_of[i] = *found;
    else
      candidates.push_back(i);  // targets are often alike
  }
  return seams_of;
}

}  // namespace

std::vector<uint32_t> lowest_equal_rows(uint32_t row_count, std::span<const std::byte> bytes, size_t stride,
                                        std::span<const uint32_t> group, const ThreadPool& pool) {
  constexpr size_t kGrain = 1 << 14;
  constexpr uint32_t kMostShares = 64;
  Array<uint32_t> hashes(row_count);
  pool.for_ranges(row_count, kGrain, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row)
      hashes[row] = hash_row(bytes.data() + row * stride, stride, group.empty() ? 0 : group[row]);
  });
  // Each thread takes the rows with hashes of its own, so that equal rows meet.
  const auto threads = static_cast<uint32_t>(pool.thread_count());
  const uint32_t share_count = row_count <= kGrain ? 1 : std::min(std::bit_ceil(threads), kMostShares);
  const auto share_of = [&](uint32_t row) { return uint64_t{hashes[row]} * share_count >> 32; };
  std::vector<uint32_t> lowest(row_count);
  pool.for_each(share_count, [&](size_t share) {
    uint32_t own_count = 0;
    for (uint32_t row = 0; row < row_count; ++row) own_count += share_of(row) == share ? 1 : 0;
    RowTable table(bytes, stride, group, hashes, own_count);
    const auto store = [&](uint32_t row, uint32_t lowest_row) { lowest[row] = lowest_row; };
    for (uint32_t row = 0; row < row_count; ++row)
      if (share_of(row) == share) table.add(row, store);
    table.finish(store);
  });
  return lowest;
}

bool are_all_lowest(std::span<const uint32_t> lowest) {
  uint32_t differences = 0;  // without a branch that would keep the loop from being done by vectors
  for (uint32_t row = 0; row < lowest.size(); ++row) differences |= lowest[row] ^ row;
  return differences == 0;
}

std::vector<uint32_t> find_duplicates(const Mesh& mesh, std::span<const std::byte> extra, size_t extra_stride,
                                      const ThreadPool& pool, const ComparedBytes& compared) {
  std::vector<uint32_t> lowest;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const Attribute& attribute = mesh.attributes[i];
    const Array<std::byte> bytes = compared ? compared(i) : Array<std::byte>();
    lowest = lowest_equal_rows(mesh.point_count, bytes.empty() ? attribute.values : bytes, attribute.stride(),
                               lowest, pool);
    if (are_all_lowest(lowest)) return lowest;
  }
  if (extra_stride > 0) lowest = lowest_equal_rows(mesh.point_count, extra, extra_stride, lowest, pool);
  return lowest;
}

WeldedMesh weld(const Mesh& mesh, const ThreadPool& pool, bool differ_in_positions) {
  WeldedMesh welded;
  welded.mesh = &mesh;
  const size_t attribute_count = mesh.attributes.size();
  welded.value_of_point.resize(attribute_count);
  const size_t position = position_index(mesh);
  const auto rows = [&](size_t i, std::span<const uint32_t> group) {
    return lowest_equal_rows(mesh.point_count, mesh.attributes[i].values, mesh.attributes[i].stride(), group,
                             pool);
  };
  if (differ_in_positions) {
    welded.value_of_point[position].resize(mesh.point_count);
    std::iota(welded.value_of_point[position].begin(), welded.value_of_point[position].end(), 0u);
  } else {
    welded.value_of_point[position] = rows(position, {});
  }
  pool.for_each(attribute_count, [&](size_t i) {
    if (i != position) welded.value_of_point[i] = rows(i, welded.value_of_point[position]);
  });

  std::vector<uint32_t>& last =
      welded.value_of_point[position + 1 == attribute_count ? 0 : attribute_count - 1];
  if (!differ_in_positions)
    for (const uint32_t point : full_duplicates(welded, welded.value_of_point[position], pool))
      last[point] = point;
  welded.seams_of = find_seams_of(welded, position);
  return welded;
}

void separate_flat_faces(WeldedMesh& welded) {
  std::vector<uint32_t>& vertex = welded.value_of_point[position_index(*welded.mesh)];
  if (are_all_lowest(vertex)) return;
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
