#include "encoder/stitching/build_stitching.h"

#include <algorithm>
#include <array>

#include "encoder/stitching/stitch_map.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = PointOwner::kNone;

// The length of the run from walk[begin] on: as long as the owner's walk continues in the same direction.
uint32_t run_length(const OwnedStream& stream, std::span<const PointOwner> owners,
                    std::span<const uint8_t> is_reference, size_t begin, bool forward) {
  const std::vector<uint32_t>& walk = stream.walk;
  const PointOwner& first = owners[stream.points[walk[begin]]];
  uint32_t length = 1;
  for (; begin + length < walk.size(); ++length) {
    const uint32_t point = walk[begin + length];
    const PointOwner& owner = owners[stream.points[point]];
    // Counting down past the walk's first place would give kNone, which is not a place.
    if (!forward && length > first.walk_place) break;
    const uint32_t place = forward ? first.walk_place + length : first.walk_place - length;
    if (!is_reference[point] || owner.stream != first.stream || owner.walk_place != place) break;
  }
  return length;
}

// The least length of a run. Shorter ones are stored as repeats if the stream owns the points itself, otherwise
// as pairs.
struct LeastLengths {
  uint32_t own = 1, others = 1;
};

StitchMap build_map(const OwnedStream& stream, uint32_t number, std::span<const PointOwner> owners,
                    std::vector<uint8_t> is_reference, const LeastLengths& least) {
  StitchMap map;
  const std::vector<uint32_t>& walk = stream.walk;
  for (size_t i = 0; i < walk.size();) {
    const PointOwner& owner = owners[stream.points[walk[i]]];
    if (!is_reference[walk[i]] || owner.walk_place == kNone) {
      ++i;
      continue;
    }
    const uint32_t backward = run_length(stream, owners, is_reference, i, false);
    const uint32_t forward = run_length(stream, owners, is_reference, i, true);
    const bool goes_forward = forward > backward;
    const uint32_t length = goes_forward ? forward : backward;
    if (length < (owner.stream == number ? least.own : least.others)) {
      ++i;
      continue;
    }
    map.runs.push_back({static_cast<uint32_t>(i), length, owner.stream, owner.walk_place, goes_forward});
    for (size_t end = i + length; i < end; ++i) is_reference[walk[i]] = 0;
  }
  for (uint32_t point = 0; point < stream.points.size(); ++point) {
    if (!is_reference[point]) continue;
    const PointOwner& owner = owners[stream.points[point]];
    if (owner.stream == number)
      map.repeats.push_back({point, owner.point});
    else
      map.pairs.push_back({point, owner.stream, owner.rank});
  }
  return map;
}

// The shortest encoding over all choices of least lengths. Usually all runs are long, and there is only one
// choice.
std::vector<uint8_t> shortest_part(const OwnedStream& stream, uint32_t number,
                                   std::span<const PointOwner> owners,
                                   const std::vector<uint8_t>& is_reference) {
  const auto point_count = static_cast<uint32_t>(stream.points.size());
  const StitchMap all_runs = build_map(stream, number, owners, is_reference, {});
  std::vector<uint8_t> shortest = write_stitch_map(all_runs, number, point_count);
  LeastLengths shortest_runs = {kNone, kNone};
  for (const StitchRun& run : all_runs.runs) {
    uint32_t& length = run.owner == number ? shortest_runs.own : shortest_runs.others;
    length = std::min(length, run.length);
  }
  constexpr std::array<uint32_t, 5> kLeastLengths = {1, 2, 3, 5, 9};
  for (const uint32_t own : kLeastLengths)
    for (const uint32_t others : kLeastLengths) {
      const bool changes_own = own > shortest_runs.own, changes_others = others > shortest_runs.others;
      if ((own > 1 && !changes_own) || (others > 1 && !changes_others) || (!changes_own && !changes_others))
        continue;
      const StitchMap map = build_map(stream, number, owners, is_reference, {own, others});
      std::vector<uint8_t> part = write_stitch_map(map, number, point_count);
      if (part.size() <= shortest.size()) shortest = std::move(part);
    }
  return shortest;
}

}  // namespace

Stitching build_stitching(std::span<const OwnedStream> streams, uint32_t first_stream,
                          std::span<PointOwner> owners, const ThreadPool& pool) {
  const size_t count = streams.size();
  Stitching stitching;
  stitching.reference_counts.resize(count);
  stitching.source_point.reserve(owners.size());
  std::vector<std::vector<uint8_t>> is_reference(count);
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t rank = 0;
    is_reference[i].resize(streams[i].points.size());
    for (uint32_t point = 0; point < streams[i].points.size(); ++point) {
      const uint32_t source = streams[i].points[point];
      if (owners[source].stream == kNone) {
        owners[source] = {first_stream + i, point, rank++, kNone};
        stitching.source_point.push_back(source);
      } else {
        is_reference[i][point] = 1;
        ++stitching.reference_counts[i];
      }
    }
    // Only a decoded point that its stream owns can be the target of a run.
    const std::vector<uint32_t>& walk = streams[i].walk;
    for (uint32_t place = 0; place < walk.size(); ++place)
      if (!is_reference[i][walk[place]]) owners[streams[i].points[walk[place]]].walk_place = place;
  }

  stitching.maps.resize(count);
  pool.for_each(count, [&](size_t i) {
    if (stitching.reference_counts[i] > 0)
      stitching.maps[i] =
          shortest_part(streams[i], first_stream + static_cast<uint32_t>(i), owners, is_reference[i]);
  });
  return stitching;
}

}  // namespace psplit
