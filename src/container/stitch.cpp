#include "src/container/stitch.h"

#include <algorithm>
#include <optional>

#include "src/container/varint.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

// Points that leave and enter each point along the directed edges of all faces, as two compressed rows.
struct DirectedEdges {
  std::vector<uint32_t> first;  // point_count + 1 entries, for both directions
  std::vector<uint32_t> to, from;

  DirectedEdges(std::span<const Face> faces, uint32_t point_count)
      : first(size_t{point_count} + 1), to(faces.size() * 3), from(faces.size() * 3) {
    // A face brings each of its points one edge out and one in, so one set of offsets serves both.
    for (const Face& face : faces)
      for (uint32_t point : face) ++first[point + 1];
    for (uint32_t point = 0; point < point_count; ++point) first[point + 1] += first[point];
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    for (const Face& face : faces)
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t slot = next[face[i]]++;
        to[slot] = face[(i + 1) % 3];
        from[slot] = face[(i + 2) % 3];
      }
  }

  size_t degree(uint32_t point) const { return first[point + 1] - first[point]; }

  // Looks in the shorter of the two rows: a hub with thousands of spokes costs its spokes one look each.
  bool has(uint32_t a, uint32_t b) const {
    const bool from_a = degree(a) <= degree(b);
    const std::vector<uint32_t>& row = from_a ? to : from;
    const uint32_t at = from_a ? a : b;
    const auto begin = row.begin() + first[at];
    const auto end = row.begin() + first[at + 1];
    return std::find(begin, end, from_a ? b : a) != end;
  }
};

Status broken(uint32_t patch, const char* what) {
  return invalid_input(std::string("stitch map: ") + what, {.patch = patch});
}

}  // namespace

std::vector<uint32_t> border_walk(std::span<const Face> faces, uint32_t point_count) {
  const DirectedEdges edges(faces, point_count);
  std::vector<uint32_t> successor(point_count, kNone);
  size_t border_count = 0;
  for (const Face& face : faces)
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = face[i], b = face[(i + 1) % 3];
      if (edges.has(b, a)) continue;
      if (successor[a] != kNone) return {};
      successor[a] = b;
      ++border_count;
    }
  std::vector<uint32_t> walk;
  walk.reserve(border_count);
  for (uint32_t start = 0; start < point_count; ++start) {
    if (successor[start] == kNone) continue;
    uint32_t at = start;
    do {
      const uint32_t next = successor[at];
      if (next == kNone) return {};
      walk.push_back(at);
      successor[at] = kNone;
      at = next;
    } while (at != start);
  }
  return walk;
}

// Runs: count, then for each the walk points skipped since the last run, (length - 1) * 2 + forward, how many
// patches back the owner is, and the start. Pairs until the bytes end: points skipped since the last pair, how
// many patches back the owner is, the rank.
std::vector<uint8_t> write_stitch_map(const StitchMap& map, uint32_t patch) {
  std::vector<uint8_t> bytes;
  if (map.runs.empty() && map.pairs.empty()) return bytes;
  append_varint(bytes, static_cast<uint32_t>(map.runs.size()));
  uint32_t next = 0;
  for (const StitchRun& run : map.runs) {
    append_varint(bytes, run.begin - next);
    append_varint(bytes, (run.length - 1) << 1 | (run.forward ? 1u : 0u));
    append_varint(bytes, patch - run.owner);
    append_varint(bytes, run.start);
    next = run.begin + run.length;
  }
  next = 0;
  for (const StitchPair& pair : map.pairs) {
    append_varint(bytes, pair.point - next);
    append_varint(bytes, patch - pair.owner);
    append_varint(bytes, pair.rank);
    next = pair.point + 1;
  }
  return bytes;
}

Expected<StitchMap> parse_stitch_map(const Container& container, uint32_t patch) {
  const StreamEntry& entry = container.entries[patch];
  StitchMap map;
  VarintReader reader(container.stitch[patch]);
  if (container.stitch[patch].empty()) {
    if (entry.reference_count != 0) return broken(patch, "the directory counts references, but there are none");
    return map;
  }
  const std::optional<uint32_t> run_count = reader.read();
  // A run takes four bytes at least.
  if (!run_count || *run_count > reader.remaining() / 4) return broken(patch, "impossible number of runs");
  const bool is_residue = container.has_residue && patch + 1 == container.entries.size();
  if (is_residue && *run_count > 0) return broken(patch, "the residue has no border to run along");
  uint64_t references = 0;
  uint64_t next = 0;
  map.runs.reserve(*run_count);
  for (uint32_t i = 0; i < *run_count; ++i) {
    const auto skip = reader.read(), length_and_way = reader.read(), back = reader.read(),
               start = reader.read();
    if (!start) return broken(patch, "ends within a run");
    const uint64_t begin = next + *skip;
    const uint32_t length = (*length_and_way >> 1) + 1;
    const bool forward = (*length_and_way & 1) != 0;
    if (begin + length > entry.point_count) return broken(patch, "a run leaves the patch");
    if (*back > patch) return broken(patch, "a run names a patch that does not exist");
    const uint32_t owner = patch - *back;
    const uint32_t owner_points = container.entries[owner].point_count;
    if (*start >= owner_points || (forward ? uint64_t{*start} + length > owner_points : *start + 1 < length))
      return broken(patch, "a run leaves its owner");
    map.runs.push_back({static_cast<uint32_t>(begin), length, owner, *start, forward});
    references += length;
    next = begin + length;
  }
  next = 0;
  while (reader.remaining() > 0) {
    const auto skip = reader.read(), back = reader.read(), rank = reader.read();
    if (!rank) return broken(patch, "ends within a pair");
    const uint64_t point = next + *skip;
    if (point >= entry.point_count) return broken(patch, "a pair names a point that does not exist");
    if (*back > patch) return broken(patch, "a pair names a patch that does not exist");
    const uint32_t owner = patch - *back;
    if (*rank >= container.owned_base[owner + 1] - container.owned_base[owner])
      return broken(patch, "a pair names a point that its owner does not own");
    map.pairs.push_back({static_cast<uint32_t>(point), owner, *rank});
    next = point + 1;
  }
  references += map.pairs.size();
  if (references != entry.reference_count) return broken(patch, "the directory counts other references");
  return map;
}

Expected<std::vector<std::vector<uint32_t>>> number_points(const Container& container,
                                                           std::span<const std::span<const Face>> faces,
                                                           const ThreadPool& pool) {
  const size_t count = container.entries.size();
  std::vector<StitchMap> maps(count);
  std::vector<uint8_t> needs_walk(count, 0);
  for (uint32_t patch = 0; patch < count; ++patch) {
    Expected<StitchMap> map = parse_stitch_map(container, patch);
    if (!map) return map.status();
    maps[patch] = std::move(*map);
    for (const StitchRun& run : maps[patch].runs) needs_walk[patch] = needs_walk[run.owner] = 1;
  }

  // First every patch numbers what it owns, which takes its own walk and nothing of its neighbours.
  std::vector<std::vector<uint32_t>> walks(count), numbers(count);
  std::vector<Status> statuses(count);
  pool.for_each(count, [&](size_t i) {
    const auto patch = static_cast<uint32_t>(i);
    const StreamEntry& entry = container.entries[i];
    if (needs_walk[i]) walks[i] = border_walk(faces[i], entry.point_count);
    std::vector<uint8_t> is_reference(entry.point_count, 0);
    const auto mark = [&](uint32_t point) { return std::exchange(is_reference[point], uint8_t{1}) == 0; };
    for (const StitchRun& run : maps[i].runs)
      for (uint32_t k = 0; k < run.length; ++k)
        if (run.begin + k >= walks[i].size() || !mark(walks[i][run.begin + k])) {
          statuses[i] = broken(patch, "a run leaves the border, or crosses itself");
          return;
        }
    for (const StitchPair& pair : maps[i].pairs)
      if (!mark(pair.point)) {
        statuses[i] = broken(patch, "a point has two references");
        return;
      }
    numbers[i].resize(entry.point_count);
    uint32_t next = container.owned_base[i];
    for (uint32_t point = 0; point < entry.point_count; ++point)
      numbers[i][point] = is_reference[point] ? kNone : next++;
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);

  // Then references take their owners' numbers. Owners only read what the first step wrote: a reference's
  // target must be owned, so no chain of references is followed; resolved ones are kept aside until all are.
  std::vector<std::vector<uint32_t>> resolved(count);
  pool.for_each(count, [&](size_t i) {
    const auto patch = static_cast<uint32_t>(i);
    for (const StitchRun& run : maps[i].runs)
      for (uint32_t k = 0; k < run.length; ++k) {
        const uint32_t at = run.forward ? run.start + k : run.start - k;
        const std::vector<uint32_t>& walk = walks[run.owner];
        const uint32_t number = at < walk.size() ? numbers[run.owner][walk[at]] : kNone;
        if (number == kNone) {
          statuses[i] = broken(patch, "a run names a point that its owner does not own");
          return;
        }
        resolved[i].push_back(number);
      }
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);
  pool.for_each(count, [&](size_t i) {
    size_t next = 0;
    for (const StitchRun& run : maps[i].runs)
      for (uint32_t k = 0; k < run.length; ++k) numbers[i][walks[i][run.begin + k]] = resolved[i][next++];
    for (const StitchPair& pair : maps[i].pairs)
      numbers[i][pair.point] = container.owned_base[pair.owner] + pair.rank;
  });
  return numbers;
}

}  // namespace psplit
