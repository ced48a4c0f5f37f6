#include "tests/support/emulated_warp.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

#include "tests/support/fibre.h"
#include "tests/support/sanitizers.h"

#if defined(PSPLIT_TSAN)
#include <sanitizer/tsan_interface.h>
extern "C" {
void AnnotateIgnoreReadsBegin(const char* file, int line);
void AnnotateIgnoreReadsEnd(const char* file, int line);
void AnnotateIgnoreWritesBegin(const char* file, int line);
void AnnotateIgnoreWritesEnd(const char* file, int line);
}
#endif

namespace psplit {

namespace {

// Tells the thread sanitizer that lanes are threads whose accesses are ordered only by syncs and by the start
// and the end of a run. The emulation itself is hidden from it.
#if defined(PSPLIT_TSAN)
void begin_ignoring() {
  AnnotateIgnoreReadsBegin(__FILE__, __LINE__);
  AnnotateIgnoreWritesBegin(__FILE__, __LINE__);
}
void end_ignoring() {
  AnnotateIgnoreReadsEnd(__FILE__, __LINE__);
  AnnotateIgnoreWritesEnd(__FILE__, __LINE__);
}
void release(void* meeting) { __tsan_release(meeting); }
void acquire(void* meeting) { __tsan_acquire(meeting); }
#else
void begin_ignoring() {}
void end_ignoring() {}
void release(void*) {}
void acquire(void*) {}
#endif

}  // namespace

class EmulatedWarp {
 public:
  static constexpr uint32_t kSize = EmulatedLanes::size();

  struct Call {
    enum Kind : uint8_t { kBallot, kShuffle32, kShuffle64, kSync, kReturn } kind;
    const char* file;
    int line;
  };

  // The arguments of the lanes in one collective call.
  struct Round {
    std::array<uint64_t, kSize> words;
    uint32_t ballot = 0;
  };

  EmulatedWarp() {
    for (uint32_t rank = 0; rank < kSize; ++rank) {
      starts_[rank] = {this, rank};
      lanes_[rank] =
          std::make_unique<Fibre>(&EmulatedWarp::run_lane, &starts_[rank], kLaneStackBytes, 576 * rank);
    }
  }

  void run(const std::function<void(EmulatedLanes)>& body, LaneOrder order) {
    if (body_ != nullptr) fail("a lane runs another warp");
    body_ = &body;
    kind_ = order.kind;
    random_ = order.seed;
    for (uint32_t i = 0; i < kSize; ++i) order_[i] = kind_ == LaneOrder::kDescending ? kSize - 1 - i : i;
    release(&body_);
    begin_ignoring();
    start_round();
    lanes_[order_[0]]->switch_from(caller_);
    end_ignoring();
    acquire(&caller_);
    body_ = nullptr;
  }

  // Waits until every lane has reached the call. Returns the ballot, or otherwise the word of lane `source`.
  uint64_t meet(uint32_t rank, Call call, uint64_t word, uint32_t source) {
    begin_ignoring();
    const uint32_t arrived = arrived_++;
    if (arrived == 0) {
      first_ = call;
    } else if (call.kind != first_.kind || call.line != first_.line ||
               (call.file != first_.file && std::strcmp(call.file, first_.file) != 0)) {
      fail_apart(rank, call);
    }
    Round& round = rounds_[parity_];
    round.words[rank] = word;
    if (call.kind == Call::kBallot) round.ballot |= static_cast<uint32_t>(word) << rank;
    if (call.kind == Call::kSync) release(&round);
    const bool all = arrived + 1 == kSize, returns = call.kind == Call::kReturn;
    if (all && !returns) start_round();
    Fibre& next = all && returns ? caller_ : *lanes_[order_[all ? 0 : arrived + 1]];
    Fibre& self = *lanes_[rank];
    if (returns) {
      end_ignoring();
      release(&caller_);
      next.switch_from(self);
      return 0;
    }
    next.switch_from(self);
    if (call.kind == Call::kSync) acquire(&round);
    const uint64_t result = call.kind == Call::kBallot ? round.ballot : round.words[source];
    end_ignoring();
    return result;
  }

  [[noreturn]] static void fail(const char* what) {
    std::fprintf(stderr, "emulated warp: %s\n", what);
    std::abort();
  }

 private:
  struct Start {
    EmulatedWarp* warp;
    uint32_t rank;
  };

  static void run_lane(void* argument) noexcept {
    const Start start = *static_cast<Start*>(argument);
    // Fibres outlive a run. They wait for the next run where they ended the last one.
    for (;;) {
      acquire(&start.warp->body_);
      (*start.warp->body_)(EmulatedLanes(start.warp, start.rank));
      start.warp->meet(start.rank, {Call::kReturn, "", 0}, 0, 0);
    }
  }

  // Some lanes may still read the last round while others write this one. None reads it any more when the next
  // begins.
  void start_round() {
    arrived_ = 0;
    parity_ ^= 1;
    rounds_[parity_].ballot = 0;
    if (kind_ != LaneOrder::kShuffled) return;
    for (uint32_t i = kSize - 1; i > 0; --i) {
      random_ = random_ * 6364136223846793005u + 1442695040888963407u;
      std::swap(order_[i], order_[(random_ >> 32) * (i + 1) >> 32]);
    }
  }

  [[noreturn]] void fail_apart(uint32_t rank, const Call& call) const {
    char text[2][600];
    const auto describe = [](char(&out)[600], uint32_t lane, const Call& where) {
      constexpr const char* kNames[] = {"ballot", "shuffle", "64-bit shuffle", "sync"};
      if (where.kind == Call::kReturn)
        std::snprintf(out, sizeof out, "lane %u has returned", lane);
      else
        std::snprintf(out, sizeof out, "lane %u is in %s at %s:%d", lane, kNames[where.kind], where.file,
                      where.line);
    };
    describe(text[0], order_[0], first_);
    describe(text[1], rank, call);
    char both[1300];
    std::snprintf(both, sizeof both, "lanes do not meet: %s, %s", text[0], text[1]);
    fail(both);
  }

  Fibre caller_;
  std::array<Start, kSize> starts_{};
  std::array<std::unique_ptr<Fibre>, kSize> lanes_;
  const std::function<void(EmulatedLanes)>* body_ = nullptr;

  // The order in which lanes run to the next call. The first `arrived_` of them have reached it.
  std::array<uint32_t, kSize> order_{};
  uint32_t arrived_ = 0;
  Call first_{};
  std::array<Round, 2> rounds_;
  uint32_t parity_ = 0;
  LaneOrder::Kind kind_ = LaneOrder::kAscending;
  uint64_t random_ = 0;
};

namespace {

void check_source(uint32_t rank, uint32_t source, const char* file, int line) {
  if (source < EmulatedLanes::size()) return;
  char text[600];
  std::snprintf(text, sizeof text, "lane %u shuffles from lane %u, which is not there, at %s:%d", rank, source,
                file, line);
  EmulatedWarp::fail(text);
}

}  // namespace

uint32_t EmulatedLanes::ballot(bool flag, const char* file, int line) const {
  return static_cast<uint32_t>(warp_->meet(rank_, {EmulatedWarp::Call::kBallot, file, line}, flag, rank_));
}

uint32_t EmulatedLanes::shuffle(uint32_t word, uint32_t source, const char* file, int line) const {
  check_source(rank_, source, file, line);
  return static_cast<uint32_t>(warp_->meet(rank_, {EmulatedWarp::Call::kShuffle32, file, line}, word, source));
}

uint64_t EmulatedLanes::shuffle(uint64_t wide, uint32_t source, const char* file, int line) const {
  check_source(rank_, source, file, line);
  return warp_->meet(rank_, {EmulatedWarp::Call::kShuffle64, file, line}, wide, source);
}

void EmulatedLanes::sync(const char* file, int line) const {
  warp_->meet(rank_, {EmulatedWarp::Call::kSync, file, line}, 0, rank_);
}

void run_warp(const std::function<void(EmulatedLanes)>& body, LaneOrder order) {
  thread_local EmulatedWarp warp;
  warp.run(body, order);
}

}  // namespace psplit
