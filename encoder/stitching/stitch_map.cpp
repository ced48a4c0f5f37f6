#include "encoder/stitching/stitch_map.h"

#include <algorithm>
#include <bit>

#include "src/core/stitch_codes.h"

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

// Bits from the lowest of each byte up.
class BitWriter {
 public:
  void put(uint64_t bits, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i, ++bit_count_) {
      if (bit_count_ % 8 == 0) bytes_.push_back(0);
      bytes_.back() |= static_cast<uint8_t>((bits >> i & 1) << bit_count_ % 8);
    }
  }
  void number(core::NumberKind& kind, uint64_t value) {
    const uint64_t high = (value >> kind.order()) + 1;
    const auto zeros = static_cast<uint32_t>(std::bit_width(high)) - 1;
    put(uint64_t{1} << zeros, zeros + 1);
    put(high, zeros);  // its highest bit is known
    put(value, kind.order());
    kind.follow(static_cast<uint32_t>(value));
  }
  std::vector<uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<uint8_t> bytes_;
  uint32_t bit_count_ = 0;  // modulo 2^32
};

// Writes what core::StitchReader reads.
class StitchWriter {
 public:
  StitchWriter(const StitchMap& map, uint32_t patch, uint32_t point_count, bool distances_differ)
      : patch_(patch), kinds_(point_count, reference_count(map)) {
    bits_.number(kinds_.count, map.runs.size());
    write_runs(map.runs);
    if (!map.repeats.empty() || !map.pairs.empty()) {
      if (patch > 0) bits_.number(kinds_.count, map.pairs.size());
      write_repeats(map.repeats, distances_differ);
      write_pairs(map.pairs);
    }
  }
  std::vector<uint8_t> take() { return bits_.take(); }

 private:
  static uint32_t reference_count(const StitchMap& map) {
    size_t count = map.repeats.size() + map.pairs.size();
    for (const StitchRun& run : map.runs) count += run.length;
    return static_cast<uint32_t>(count);
  }
  // Where a step takes more than 32 bits, the owner is named as if it were another.
  bool goes_on(bool is_first, bool is_same_owner, int64_t step) {
    const bool result = !is_first && is_same_owner && core::fold(step) <= 0xffffffffu;
    if (!is_first) bits_.put(result ? 0 : 1, 1);
    return result;
  }
  void write_runs(std::span<const StitchRun> runs) {
    core::ExpectedStart expected;
    const StitchRun* last = nullptr;
    for (const StitchRun& run : runs) {
      const uint32_t skip = run.begin - (last ? last->begin + last->length : 0);
      bits_.number(kinds_.walk_skip, skip);
      bits_.number(kinds_.length, run.length - 1);
      if (run.length > 1) bits_.put(run.forward ? 1 : 0, 1);
      const int64_t step = expected.step(skip, run.start);
      if (goes_on(last == nullptr, last && run.owner == last->owner, step)) {
        bits_.number(kinds_.start_step, core::fold(step));
      } else {
        bits_.number(kinds_.back, patch_ - run.owner);
        bits_.number(kinds_.place, run.start);
      }
      expected = core::ExpectedStart(run.start, run.length, run.length > 1 && run.forward);
      last = &run;
    }
  }
  void write_repeats(std::span<const StitchRepeat> repeats, bool distances_differ) {
    if (!repeats.empty()) bits_.put(distances_differ ? 1 : 0, 1);
    uint32_t next = 0, last_distance = 0;
    for (const StitchRepeat& repeat : repeats) {
      bits_.number(kinds_.point_skip, repeat.point - next);
      const uint32_t distance = repeat.point - 1 - repeat.target;
      bits_.number(kinds_.distance,
                   distances_differ ? core::fold(int64_t{distance} - last_distance) : distance);
      last_distance = distance;
      next = repeat.point + 1;
    }
  }
  void write_pairs(std::span<const StitchPair> pairs) {
    core::ExpectedRank expected;
    const StitchPair* last = nullptr;
    for (const StitchPair& pair : pairs) {
      bits_.number(kinds_.point_skip, pair.point - (last ? last->point + 1 : 0));
      const int64_t step = expected.step(pair.rank);
      if (goes_on(last == nullptr, last && pair.owner == last->owner, step)) {
        bits_.number(kinds_.rank_step, core::fold(step));
        expected.follow(pair.rank);
      } else {
        bits_.number(kinds_.back, patch_ - pair.owner - 1);
        bits_.number(kinds_.place, pair.rank);
        expected.begin(pair.rank);
      }
      last = &pair;
    }
  }

  uint32_t patch_;
  core::StitchKinds kinds_;
  BitWriter bits_;
};

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

std::vector<uint8_t> write_stitch_map(const StitchMap& map, uint32_t patch, uint32_t point_count) {
  if (map.runs.empty() && map.repeats.empty() && map.pairs.empty()) return {};
  std::vector<uint8_t> bytes = StitchWriter(map, patch, point_count, false).take();
  // Half of all differences take one bit more than distances do.
  if (map.repeats.empty() || point_count >= 0x80000000u) return bytes;
  std::vector<uint8_t> by_differences = StitchWriter(map, patch, point_count, true).take();
  return by_differences.size() < bytes.size() ? by_differences : bytes;
}

Expected<StitchMap> parse_stitch_map(const PatchContainer& container, uint32_t patch) {
  const StreamEntry& entry = container.entries[patch];
  const bool is_residue = container.has_residue && patch + 1 == container.entries.size();
  StitchMap map;
  core::StitchReader reader(container.stitch_row(patch));
  uint64_t references = 0;
  for (core::StitchReader::Run run; reader.next_run(run); references += run.length) {
    if (is_residue) return broken(patch, "the residue has no border to run along");
    if (run.begin + run.length > entry.point_count) return broken(patch, "a run leaves the patch");
    const uint32_t owner_points = container.entries[run.owner].point_count;
    if (run.start >= owner_points || (run.forward && uint64_t{run.start} + run.length > owner_points))
      return broken(patch, "a run leaves its owner");
    map.runs.push_back({static_cast<uint32_t>(run.begin), run.length, run.owner, run.start, run.forward});
  }
  for (core::StitchReader::Pair pair; reader.next_pair(pair); ++references) {
    if (pair.point >= entry.point_count) return broken(patch, "a pair names a point that does not exist");
    const auto point = static_cast<uint32_t>(pair.point);
    if (pair.is_repeat) {
      map.repeats.push_back({point, pair.target});
      continue;
    }
    if (pair.target >= container.owned_base[pair.owner + 1] - container.owned_base[pair.owner])
      return broken(patch, "a pair names a point that its owner does not own");
    map.pairs.push_back({point, pair.owner, pair.target});
  }
  if (reader.broken())
    return broken(patch, "ends early, goes on too long, or names a patch that does not exist");
  if (references != entry.reference_count) return broken(patch, "the directory counts other references");
  return map;
}

Expected<std::vector<std::vector<uint32_t>>> number_points(const PatchContainer& container,
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
    bool is_twice = false;
    for (const StitchRepeat& repeat : maps[i].repeats) is_twice |= !mark(repeat.point);
    for (const StitchPair& pair : maps[i].pairs) is_twice |= !mark(pair.point);
    bool is_unowned = false;
    for (const StitchRepeat& repeat : maps[i].repeats) is_unowned |= is_reference[repeat.target] != 0;
    if (is_twice || is_unowned) {
      statuses[i] = broken(patch, is_twice ? "a point has two references" : "a point repeats a reference");
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
    for (const StitchRepeat& repeat : maps[i].repeats) numbers[i][repeat.point] = numbers[i][repeat.target];
    for (const StitchPair& pair : maps[i].pairs)
      numbers[i][pair.point] = container.owned_base[pair.owner] + pair.rank;
  });
  return numbers;
}

}  // namespace psplit
