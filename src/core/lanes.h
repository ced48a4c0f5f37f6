// Code for lanes: it runs on one thread alone or on the 32 threads of a warp together.
//
// All lanes call the same function with the same arguments; only `lanes` differs. Local variables belong to one
// lane, and arrays are shared by all lanes. Calls are collective unless their comment says otherwise: all lanes
// must make the same calls in the same order. So no lane may return early, or make a collective call in a
// branch that others do not take. If one lane finds a fault, all lanes end (any).
//
// After the next sync, other lanes may read what a lane wrote to an array. A lane may overwrite what others
// read only after a sync, too. ballot and shuffle do not order memory. The functions here that write arrays end
// with a sync.
//
// The kinds of lanes are SerialLanes here, WarpLanes of CUDA (decoder_cuda), and the emulated warp of the
// tests.
//
// Most code is written once. Where one thread has a faster way than lanes have, both are written: twins, whose
// results are the same. Tests compare them, or both of them with libdraco.
//
//   seams.h, SeamDecoder::finish     seam_lanes.h: seams to tables and points, one thread only where seams are
//   Connectivity::move_up            numbers without gaps
//   CreationOrder (condensed)        the order of created values
//   RansTable::fill_buckets          the first slot of each bucket
//   the steps of predictions         the functions for lanes beside them, which compute several values at once:
//                                    parallelogram.h, multi_parallelogram.h, normals.h, condensed/creation.h
#pragma once

#include "src/core/view.h"

namespace psplit::core {

template <typename A, typename B>
inline constexpr bool kSameType = false;
template <typename A>
inline constexpr bool kSameType<A, A> = true;
template <typename A, typename B>
concept SameAs = kSameType<A, B>;

template <typename L>
concept Lanes = requires(const L lanes, bool flag, uint32_t source, uint32_t word, uint64_t wide) {
  // The number of lanes: a constant power of two, at most 32.
  requires(L::size() >= 1 && L::size() <= 32 && (L::size() & (L::size() - 1)) == 0);
  // The number of this lane, below size(). Not collective.
  { lanes.rank() } -> SameAs<uint32_t>;
  // Bit r is the flag of lane r.
  { lanes.ballot(flag) } -> SameAs<uint32_t>;
  // The `word` of lane `source`, which is below size(). Each lane may name another source.
  { lanes.shuffle(word, source) } -> SameAs<uint32_t>;
  { lanes.shuffle(wide, source) } -> SameAs<uint64_t>;
  // All reads and writes of all lanes before it happen before those after it.
  lanes.sync();
};

// One thread alone. Code for these lanes compiles to plain loops.
struct SerialLanes {
  PSPLIT_HD static constexpr uint32_t size() { return 1; }
  PSPLIT_HD constexpr uint32_t rank() const { return 0; }
  PSPLIT_HD constexpr uint32_t ballot(bool flag) const { return flag; }
  PSPLIT_HD constexpr uint32_t shuffle(uint32_t word, uint32_t) const { return word; }
  PSPLIT_HD constexpr uint64_t shuffle(uint64_t wide, uint32_t) const { return wide; }
  PSPLIT_HD constexpr void sync() const {}
};

// Whether `flag` is set in any lane.
template <Lanes L>
PSPLIT_HD constexpr bool any(L lanes, bool flag) {
  return lanes.ballot(flag) != 0;
}

// The word of lane `source`. All lanes name the same source.
template <Lanes L, typename Word>
PSPLIT_HD constexpr Word broadcast(L lanes, Word word, uint32_t source) {
  return lanes.shuffle(word, source);
}

// Does work on the first lane, and returns its result on all: a fault, a flag or a number of 32 bits.
// Collective.
template <Lanes L, typename Work>
PSPLIT_HD constexpr auto alone(L lanes, Work work) {
  using Result = decltype(work());
  const Result result = lanes.rank() == 0 ? work() : Result();
  lanes.sync();
  return static_cast<Result>(broadcast(lanes, static_cast<uint32_t>(result), 0));
}

// Calls body(i) for all i below `count`: lane r takes r, r + size() and so on. Neither the call nor `body` is
// collective, as some lanes call `body` once less than others. `count` is at most 2^32 - 32.
template <Lanes L, typename Body>
PSPLIT_HD constexpr void for_each_lane_item(L lanes, uint32_t count, Body body) {
  PSPLIT_CORE_CHECK(count <= 0u - L::size());
  for (uint32_t i = lanes.rank(); i < count; i += L::size()) body(i);
}

// Arena::take on the first lane, for all lanes. Returns false if too little memory is left. Collective.
template <Lanes L, typename T>
PSPLIT_HD bool take(L lanes, Arena& arena, View<T>& out, uint64_t count) {
  if constexpr (L::size() == 1) {
    return arena.take(out, count);
  } else {
    View<T> taken;
    const bool is_taken = alone(lanes, [&] { return arena.take(taken, count); });
    const auto place = static_cast<uint64_t>(reinterpret_cast<uintptr_t>(taken.data()));
    out = View<T>(reinterpret_cast<T*>(static_cast<uintptr_t>(broadcast(lanes, place, 0))),
                  static_cast<size_t>(count));
    return is_taken;
  }
}

template <Lanes L, typename T>
PSPLIT_HD void fill(L lanes, View<T> view, T value) {
  for_each_lane_item(lanes, static_cast<uint32_t>(view.size()), [&](uint32_t i) { view[i] = value; });
  lanes.sync();
}

template <typename Word>
struct Scan {
  Word before;  // the sum over all lower lanes
  Word total;   // the sum over all lanes
};

template <Lanes L, typename Word>
PSPLIT_HD constexpr Scan<Word> exclusive_scan(L lanes, Word word) {
  const uint32_t rank = lanes.rank();
  Word sum = word;  // over the last 1, 2, 4 ... lanes up to this one
  for (uint32_t step = 1; step < L::size(); step *= 2) {
    const Word lower = lanes.shuffle(sum, rank >= step ? rank - step : rank);
    if (rank >= step) sum += lower;
  }
  return {sum - word, broadcast(lanes, sum, L::size() - 1)};
}

// Exclusive prefix sum: replaces each value with the sum of the values before it. Returns the sum of all
// values.
template <Lanes L, typename T>
PSPLIT_HD constexpr uint32_t scan_array(L lanes, View<T> values) {
  static_assert(sizeof(T) <= sizeof(uint32_t));
  const auto count = static_cast<uint32_t>(values.size());
  uint32_t sum = 0;
  for (uint32_t chunk = 0; chunk < count; chunk += L::size()) {
    const uint32_t i = chunk + lanes.rank();
    const Scan<uint32_t> scan = exclusive_scan(lanes, i < count ? uint32_t{values[i]} : 0u);
    if (i < count) values[i] = static_cast<T>(sum + scan.before);
    sum += scan.total;
  }
  lanes.sync();
  return sum;
}

}  // namespace psplit::core
