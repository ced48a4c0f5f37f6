#include "encoder/stitch_runs.h"

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

struct Owner {
  uint32_t stream = kNone;
  uint32_t rank = 0;            // among the points that the stream owns
  uint32_t walk_place = kNone;  // in the stream's border walk
};

// Extends a run from walk[begin] for as long as the same owner's walk goes along, in one direction.
uint32_t run_length(std::span<const uint32_t> walk, const OwnedStream& stream, std::span<const Owner> owners,
                    std::span<const uint8_t> is_reference, size_t begin, bool forward) {
  const Owner& first = owners[stream.points[walk[begin]]];
  uint32_t length = 1;
  for (; begin + length < walk.size(); ++length) {
    const uint32_t point = walk[begin + length];
    const Owner& owner = owners[stream.points[point]];
    // Counting down past the walk's first place would end at kNone, which is no place.
    if (!forward && length > first.walk_place) break;
    const uint32_t place = forward ? first.walk_place + length : first.walk_place - length;
    if (!is_reference[point] || owner.stream != first.stream || owner.walk_place != place) break;
  }
  return length;
}

StitchMap build_map(const OwnedStream& stream, std::span<const uint32_t> walk, std::span<const Owner> owners,
                    std::vector<uint8_t> is_reference) {
  StitchMap map;
  for (size_t i = 0; i < walk.size();) {
    const Owner& owner = owners[stream.points[walk[i]]];
    if (!is_reference[walk[i]] || owner.walk_place == kNone) {
      ++i;
      continue;
    }
    const uint32_t backward = run_length(walk, stream, owners, is_reference, i, false);
    const uint32_t forward = run_length(walk, stream, owners, is_reference, i, true);
    const bool goes_forward = forward > backward;
    const uint32_t length = goes_forward ? forward : backward;
    map.runs.push_back({static_cast<uint32_t>(i), length, owner.stream, owner.walk_place, goes_forward});
    for (size_t end = i + length; i < end; ++i) is_reference[walk[i]] = 0;
  }
  for (uint32_t point = 0; point < stream.points.size(); ++point) {
    if (!is_reference[point]) continue;
    const Owner& owner = owners[stream.points[point]];
    map.pairs.push_back({point, owner.stream, owner.rank});
  }
  return map;
}

}  // namespace

Stitching build_stitching(std::span<const OwnedStream> streams, uint32_t point_count, const ThreadPool& pool) {
  const size_t count = streams.size();
  std::vector<std::vector<uint32_t>> walks(count);
  pool.for_each(count, [&](size_t i) {
    if (!streams[i].is_residue)
      walks[i] = border_walk(streams[i].faces, static_cast<uint32_t>(streams[i].points.size()));
  });

  Stitching stitching;
  stitching.reference_counts.resize(count);
  stitching.source_point.reserve(point_count);
  std::vector<Owner> owners(point_count);
  std::vector<std::vector<uint8_t>> is_reference(count);
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t rank = 0;
    is_reference[i].resize(streams[i].points.size());
    for (uint32_t point = 0; point < streams[i].points.size(); ++point) {
      const uint32_t source = streams[i].points[point];
      if (owners[source].stream == kNone) {
        owners[source] = {i, rank++, kNone};
        stitching.source_point.push_back(source);
      } else {
        is_reference[i][point] = 1;
        ++stitching.reference_counts[i];
      }
    }
    // Only the decoded point that is owned can be the target of a run.
    for (uint32_t place = 0; place < walks[i].size(); ++place)
      if (!is_reference[i][walks[i][place]]) owners[streams[i].points[walks[i][place]]].walk_place = place;
  }

  stitching.maps.resize(count);
  pool.for_each(count, [&](size_t i) {
    stitching.maps[i] = write_stitch_map(build_map(streams[i], walks[i], owners, std::move(is_reference[i])),
                                         static_cast<uint32_t>(i));
  });
  return stitching;
}

}  // namespace psplit
