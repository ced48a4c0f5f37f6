// A warp of 32 lanes on one thread: code over core::Lanes runs as it will on a GPU, step by step the same every
// time, and within reach of debuggers and sanitizers.
//
//   run_warp([&](EmulatedLanes lanes) { decode(lanes, ...); });
//
// Each lane runs alone until it comes to a collective call, and goes on from there after all have come to it.
// So a lane that reads what another writes with no collective call between them sees it or not by the order in
// which lanes run: tests run several. Where a ballot or shuffle stands and a sync is due no order tells, but
// the thread sanitizer does: to it lanes are threads, and only syncs order what they read and write.
//
// Lanes that come to different collective calls, that return while others wait, or that shuffle from a lane
// which is not there end the program with a message.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace psplit {

inline constexpr size_t kLaneStackBytes = size_t{256} << 10;

// Which lane runs when between two collective calls.
struct LaneOrder {
  enum Kind : uint8_t { kAscending, kDescending, kShuffled } kind = kAscending;
  uint64_t seed = 0;  // of kShuffled, where each time is another order
};

inline constexpr std::array<LaneOrder, 4> kLaneOrders = {
    {{LaneOrder::kAscending}, {LaneOrder::kDescending}, {LaneOrder::kShuffled, 1}, {LaneOrder::kShuffled, 2}}};

class EmulatedWarp;

// One lane's hold of its warp. Where a call is in the source is part of which call it is.
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

// Calls body(lanes) for every lane, and returns when all have. The body may not call it again, nor let
// exceptions out, and has kLaneStackBytes of stack. Threads have a warp each, whose stacks they keep.
void run_warp(const std::function<void(EmulatedLanes)>& body, LaneOrder order = {});

}  // namespace psplit
