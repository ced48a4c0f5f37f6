// A warp of 32 lanes on one thread. Code that uses core::Lanes runs as on a GPU, but deterministically, and
// debuggers and sanitizers can observe it.
//
//   run_warp([&](EmulatedLanes lanes) { decode(lanes, ...); });
//
// Each lane runs alone until it reaches a collective call, and continues after all lanes have reached it. If a
// lane reads what another lane writes, without a collective call in between, the result depends on the order of
// the lanes; tests run several orders. If a ballot or shuffle is used where a sync is required, no order shows
// it, but the thread sanitizer does: it treats lanes as threads, and only syncs order their accesses.
//
// The program ends with a message if lanes reach different collective calls, if a lane returns while others
// wait, or if a shuffle names a lane that does not exist.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace psplit {

inline constexpr size_t kLaneStackBytes = size_t{256} << 10;

// The order in which lanes run between two collective calls.
struct LaneOrder {
  enum Kind : uint8_t { kAscending, kDescending, kShuffled } kind = kAscending;
  uint64_t seed = 0;  // for kShuffled, which uses another order each time
};

inline constexpr std::array<LaneOrder, 4> kLaneOrders = {
    {{LaneOrder::kAscending}, {LaneOrder::kDescending}, {LaneOrder::kShuffled, 1}, {LaneOrder::kShuffled, 2}}};

class EmulatedWarp;

// A lane's handle of its warp. Collective calls at different places of the source are different calls.
class EmulatedLanes {
 public:
  static constexpr uint32_t size() { return 32; }
  uint32_t rank() const { return rank_; }
  uint32_t ballot(bool flag, const char* file = __builtin_FILE(), int line = __builtin_LINE()) const;
  uint32_t shuffle(uint32_t word, uint32_t source, const char* file = __builtin_FILE(),
                   int line = __builtin_LINE()) const;
  uint64_t shuffle(uint64_t wide, uint32_t source, const char* file = __builtin_FILE(),
                   int line = __builtin_LINE()) const;
  void sync(const char* file = __builtin_FILE(), int line = __builtin_LINE()) const;

 private:
  friend class EmulatedWarp;
  EmulatedLanes(EmulatedWarp* warp, uint32_t rank) : warp_(warp), rank_(rank) {}

  EmulatedWarp* warp_;
  uint32_t rank_;
};

// Calls body(lanes) for every lane, and returns when all calls have returned. The body must not call run_warp,
// must not throw, and has kLaneStackBytes of stack. Each thread has a warp of its own, and keeps its stacks.
void run_warp(const std::function<void(EmulatedLanes)>& body, LaneOrder order = {});

}  // namespace psplit
