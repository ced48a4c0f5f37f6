// From the decoded points of a container's streams to the points of the mesh. The specification, "numbering"
// and "stitch map" (gltf_ext/PSPLIT_mesh_draco_patches); src/container/stitch.h has the definition for whole
// containers.
//
//   number_mesh_points   of each stream: its own points, and which are references
//   resolve_references   when all are numbered: the points that references stand for
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/fault.h"
#include "src/core/lanes.h"

namespace psplit::core {

inline constexpr uint32_t kNoPoint = 0xffffffffu;

// What a directory says of one stream of a container.
struct StitchRow {
  View<const uint8_t> bytes;  // its part of the stitch map
  uint32_t stream = 0;        // its place in the container
  uint32_t reference_count = 0;
  uint32_t owned_base = 0;       // the mesh's number of the first point that it owns
  uint32_t first_reference = 0;  // references are numbered from here on for the time being
};

// Reads a part of the stitch map from front to back. Numbers of more than 32 bits are none.
class StitchReader {
 public:
  // `length` points of the walk from `begin` are points of stream `owner`'s walk from `start`, counting up or
  // down.
  struct Run {
    uint64_t begin = 0;
    uint32_t length = 0, owner = 0, start = 0;
    bool forward = false;

    PSPLIT_HD uint32_t place(uint32_t k) const { return forward ? start + k : start - k; }
  };
  // Point `point` is the rank-th that stream `owner` owns.
  struct Pair {
    uint64_t point = 0;
    uint32_t owner = 0, rank = 0;
  };

  PSPLIT_HD explicit StitchReader(const StitchRow& row)
      : bytes_(row.bytes.data(), row.bytes.size()), stream_(row.stream) {
    if (row.bytes.empty()) return;
    runs_left_ = number();
    // A run takes four bytes at least.
    broken_ |= runs_left_ > bytes_.remaining() / 4;
  }

  // False behind the last. All runs stand before all pairs.
  PSPLIT_HD bool next_run(Run& run) {
    if (broken_ || runs_left_ == 0) return false;
    --runs_left_;
    const uint64_t begin = next_ + number();
    const uint32_t length_and_way = number(), back = number(), start = number();
    run = {begin, (length_and_way >> 1) + 1, stream_ - back, start, (length_and_way & 1) != 0};
    next_ = runs_left_ == 0 ? 0 : begin + run.length;
    broken_ |= back > stream_ ||
               (run.forward ? uint64_t{start} + run.length > 0xffffffffu : uint64_t{start} + 1 < run.length);
    return !broken_;
  }
  PSPLIT_HD bool next_pair(Pair& pair) {
    if (broken_ || bytes_.remaining() == 0) return false;
    const uint64_t point = next_ + number();
    const uint32_t back = number(), rank = number();
    pair = {point, stream_ - back, rank};
    next_ = point + 1;
    broken_ |= back > stream_;
    return !broken_;
  }
  // Ended within a run or a pair, or names a stream that is none.
  PSPLIT_HD bool broken() const { return broken_; }

 private:
  PSPLIT_HD uint32_t number() {
    const size_t before = bytes_.position();
    const uint64_t value = bytes_.varint64();
    broken_ |= bytes_.truncated() || bytes_.position() - before > 5 || value > 0xffffffffu;
    return static_cast<uint32_t>(value);
  }

  ByteReader bytes_;
  uint32_t stream_ = 0, runs_left_ = 0;
  uint64_t next_ = 0;
  bool broken_ = false;
};

// numbers[point] becomes the mesh's number of each point that the stream owns; of the n-th reference of its
// stitch map, first_reference + n. `walk` has the points of its border. Collective.
template <Lanes L, typename Index>
PSPLIT_HD Fault number_mesh_points(L lanes, const StitchRow& row, View<const Index> walk,
                                   View<uint32_t> numbers) {
  fill(lanes, numbers, kNoPoint);
  StitchReader reader(row);
  uint32_t reference = row.first_reference;
  const uint32_t last = reference + row.reference_count;
  bool out_of_place = false;
  for (StitchReader::Run run; reader.next_run(run);) {
    if (run.begin + run.length > walk.size() || run.length > last - reference) return Fault::kStitchRun;
    const View<const Index> along(walk.data() + run.begin, run.length);
    // A walk has no point twice.
    for_each_lane_item(lanes, run.length, [&](uint32_t k) {
      uint32_t& number = numbers[along[k]];
      out_of_place |= number != kNoPoint;
      number = reference + k;
    });
    reference += run.length;
    lanes.sync();
  }
  for (StitchReader::Pair pair; reader.next_pair(pair); ++reference) {
    if (pair.point >= numbers.size() || reference == last) return Fault::kStitchPair;
    if (lanes.rank() != 0) continue;
    uint32_t& number = numbers[static_cast<size_t>(pair.point)];
    out_of_place |= number != kNoPoint;
    number = reference;
  }
  lanes.sync();
  if (reader.broken() || reference != last) return Fault::kStitchMap;
  if (any(lanes, out_of_place)) return Fault::kStitchPair;
  // The rest is its own.
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
  return Fault::kNone;
}

// resolved[n] becomes the mesh's number of the n-th reference of a row that number_mesh_points took. All
// streams up to this one are numbered: walk_of(stream, place) is the mesh's number of the point at a place of
// its walk, kNoPoint where that is a reference or there is none; owned_of(stream, rank) of the rank-th point
// that it owns, or kNoPoint. Collective.
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
    if (lanes.rank() == reference % L::size()) resolve(reference, owned_of(pair.owner, pair.rank));
  lanes.sync();
  return any(lanes, missing) ? Fault::kStitchOwner : Fault::kNone;
}

}  // namespace psplit::core
