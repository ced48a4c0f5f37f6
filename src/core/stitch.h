// Maps the decoded points of a container's streams to the points of the mesh. A stream owns some of its points;
// the others are references to points that streams own. Specification: "numbering" and "stitch map" (gltf_ext/
// PSPLIT_mesh_draco_patches).
//
//   number_mesh_points   for each stream: numbers its own points and its references, and resolves repeats
//   resolve_references   when all streams are numbered: resolves the other references
#pragma once

#include "src/core/fault.h"
#include "src/core/lanes.h"
#include "src/core/stitch_reader.h"

namespace psplit::core {

inline constexpr uint32_t kNoPoint = 0xffffffffu;

// Resolves the repeats of a row whose points are numbered. `reader` is before the first pair, which is
// reference number first_pair. Collective.
template <Lanes L>
PSPLIT_HD Fault resolve_repeats(L lanes, const StitchRow& row, StitchReader reader, uint32_t first_pair,
                                View<const uint32_t> numbers, View<uint32_t> resolved) {
  bool missing = false;
  uint32_t reference = first_pair - row.first_reference;
  for (StitchReader::Pair pair; reader.next_pair(pair) && pair.is_repeat; ++reference) {
    if (lanes.rank() != reference % L::size()) continue;
    const uint32_t number = numbers[pair.target];
    missing |= number >= row.first_reference;
    resolved[reference] = number;
  }
  lanes.sync();
  return any(lanes, missing) ? Fault::kStitchOwner : Fault::kNone;
}

// numbers[point] becomes the point's number in the mesh if the stream owns the point, and first_reference + n
// if the point is the n-th reference of its stitch map. If the n-th reference is a repeat, resolved[n] becomes
// its number in the mesh; `resolved` has a place for each reference. `walk` has the points of the stream's
// border. Collective.
template <Lanes L, typename Index>
PSPLIT_HD Fault number_mesh_points(L lanes, const StitchRow& row, View<const Index> walk,
                                   View<uint32_t> numbers, View<uint32_t> resolved) {
  fill(lanes, numbers, kNoPoint);
  StitchReader reader(row);
  uint32_t reference = row.first_reference;
  const uint32_t last = reference + row.reference_count;
  bool out_of_place = false;
  for (StitchReader::Run run; reader.next_run(run);) {
    if (run.begin + run.length > walk.size() || run.length > last - reference) return Fault::kStitchRun;
    const View<const Index> along(walk.data() + run.begin, run.length);
    // No point is in the walk twice, so no two lanes write the same number.
    for_each_lane_item(lanes, run.length, [&](uint32_t k) {
      uint32_t& number = numbers[along[k]];
      out_of_place |= number != kNoPoint;
      number = reference + k;
    });
    reference += run.length;
    lanes.sync();
  }
  const StitchReader pairs = reader;
  const uint32_t first_pair = reference;
  bool has_repeats = false;
  for (StitchReader::Pair pair; reader.next_pair(pair); ++reference) {
    if (pair.point >= numbers.size() || reference == last) return Fault::kStitchPair;
    has_repeats |= pair.is_repeat;
    if (lanes.rank() != 0) continue;
    uint32_t& number = numbers[static_cast<size_t>(pair.point)];
    out_of_place |= number != kNoPoint;
    number = reference;
  }
  lanes.sync();
  if (reader.broken() || reference != last) return Fault::kStitchMap;
  if (any(lanes, out_of_place)) return Fault::kStitchPair;
  // The stream owns all other points.
  const auto count = static_cast<uint32_t>(numbers.size());
  uint32_t next = row.owned_base;
  for (uint32_t chunk = 0; chunk < count; chunk += L::size()) {
    const uint32_t point = chunk + lanes.rank();
    const bool is_own = point < count && numbers[point] == kNoPoint;
    const Scan<uint32_t> own = exclusive_scan(lanes, uint32_t{is_own});
    if (is_own) numbers[point] = next + own.before;
    next += own.total;
  }
  lanes.sync();
  return has_repeats ? resolve_repeats(lanes, row, pairs, first_pair, numbers, resolved) : Fault::kNone;
}

// resolved[n] becomes the mesh's number of the n-th reference of a row. number_mesh_points has accepted the row
// and resolved its repeats, and all streams up to this one are numbered. walk_of(stream, place) returns the
// mesh's number of the point at a place of a stream's walk, or kNoPoint if that is a reference or does not
// exist. owned_of(stream, rank) returns the mesh's number of the rank-th point that a stream owns, or kNoPoint.
// Collective.
template <Lanes L, typename WalkOf, typename OwnedOf>
PSPLIT_HD Fault resolve_references(L lanes, const StitchRow& row, WalkOf walk_of, OwnedOf owned_of,
                                   View<uint32_t> resolved) {
  StitchReader reader(row);
  uint32_t reference = 0;
  bool missing = false;
  const auto resolve = [&](uint32_t at, uint32_t number) {
    missing |= number == kNoPoint;
    resolved[at] = number;
  };
  for (StitchReader::Run run; reader.next_run(run); reference += run.length)
    for_each_lane_item(lanes, run.length,
                       [&](uint32_t k) { resolve(reference + k, walk_of(run.owner, run.place(k))); });
  for (StitchReader::Pair pair; reader.next_pair(pair); ++reference)
    if (!pair.is_repeat && lanes.rank() == reference % L::size())
      resolve(reference, owned_of(pair.owner, pair.target));
  lanes.sync();
  return any(lanes, missing) ? Fault::kStitchOwner : Fault::kNone;
}

}  // namespace psplit::core
