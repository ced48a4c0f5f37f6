#include "encoder/stitching/stitch_map.h"

#include "src/container/bit_string.h"

namespace psplit {
namespace {

Status broken(uint32_t patch, const char* what) {
  return invalid_input(std::string("stitch map: ") + what, {.patch = patch});
}

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
  // If a step takes more than 32 bits, the owner is named as if it were another one.
  bool goes_on(bool is_first, bool is_same_owner, int64_t step) {
    const bool result = !is_first && is_same_owner && core::fold(step) <= 0xffffffffu;
    if (!is_first) bits_.bits(result ? 0 : 1, 1);
    return result;
  }
  void write_runs(std::span<const StitchRun> runs) {
    core::ExpectedStart expected;
    const StitchRun* last = nullptr;
    for (const StitchRun& run : runs) {
      const uint32_t skip = run.begin - (last ? last->begin + last->length : 0);
      bits_.number(kinds_.walk_skip, skip);
      bits_.number(kinds_.length, run.length - 1);
      if (run.length > 1) bits_.bits(run.forward ? 1 : 0, 1);
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
    if (!repeats.empty()) bits_.bits(distances_differ ? 1 : 0, 1);
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
  BitStringWriter bits_;
};

}  // namespace

std::vector<uint8_t> write_stitch_map(const StitchMap& map, uint32_t patch, uint32_t point_count) {
  if (map.runs.empty() && map.repeats.empty() && map.pairs.empty()) return {};
  std::vector<uint8_t> bytes = StitchWriter(map, patch, point_count, false).take();
  // Every second difference takes one bit more than the distance, so it is worth trying both.
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

}  // namespace psplit
