// How the numbers of a stitch map of version 2 are told in few bits: what its reader and its writer share. The
// specification, "numbers" and "stitch map" (gltf_ext/PSPLIT_mesh_draco_patches), has the same.
#pragma once

#include "src/core/platform.h"

namespace psplit::core {

// A signed number as an unsigned one that is small near 0, and back.
PSPLIT_HD constexpr uint64_t fold(int64_t value) {
  return value < 0 ? static_cast<uint64_t>(-value) * 2 - 1 : static_cast<uint64_t>(value) * 2;
}
PSPLIT_HD constexpr int64_t unfold(uint32_t value) {
  return value % 2 == 0 ? int64_t{value / 2} : -int64_t{value / 2} - 1;
}

// Numbers of one kind are exponential Golomb codes, whose order follows the numbers: after small ones, small
// ones take few bits.
class NumberKind {
 public:
  PSPLIT_HD explicit NumberKind(uint32_t order) : sixteenths_(16 * order) {}

  PSPLIT_HD uint32_t order() const { return sixteenths_ / 16; }
  PSPLIT_HD void follow(uint32_t value) { sixteenths_ = (3 * sixteenths_ + 16 * floor_log2(value)) / 4; }

 private:
  uint32_t sixteenths_;
};

// The kinds of numbers in a stream's part, with the orders that they begin with.
struct StitchKinds {
  PSPLIT_HD StitchKinds(uint32_t point_count, uint32_t reference_count)
      : place(point_count < 2 ? 0 : floor_log2(point_count) - 1),
        point_skip(reference_count == 0 ? 0 : floor_log2(point_count / reference_count)) {}

  NumberKind count{0}, back{0};
  NumberKind walk_skip{1}, length{1}, start_step{2};  // of runs
  NumberKind place;                                   // in a walk, or among the points that a stream owns
  NumberKind point_skip, distance{1}, rank_step{1};   // of repeats and pairs
};

// Runs of one owner follow each other in its walk as they do in this one, with about as many places between.
class ExpectedStart {
 public:
  ExpectedStart() = default;
  // Behind a run.
  PSPLIT_HD ExpectedStart(uint32_t start, uint32_t length, bool forward)
      : next_(forward ? int64_t{start} + length : int64_t{start} - length), sign_(forward ? 1 : -1) {}

  // Of a run that comes `skip` places later; it may be anything where the step is.
  PSPLIT_HD int64_t start(uint32_t skip, int64_t step) const { return next_ + sign_ * (skip + step); }
  PSPLIT_HD int64_t step(uint32_t skip, uint32_t start) const { return sign_ * (start - next_) - skip; }

 private:
  int64_t next_ = 0, sign_ = -1;
};

// Ranks of one owner go on as they did last, by one.
class ExpectedRank {
 public:
  PSPLIT_HD int64_t rank(int64_t step) const { return last_ + sign_ * (1 + step); }
  PSPLIT_HD int64_t step(uint32_t rank) const { return sign_ * (rank - last_) - 1; }
  PSPLIT_HD void follow(uint32_t rank) {
    sign_ = rank < last_ ? -1 : 1;
    last_ = rank;
  }
  // The first of an owner says nothing of the way.
  PSPLIT_HD void begin(uint32_t rank) { last_ = rank; }

 private:
  int64_t last_ = 0, sign_ = -1;
};

}  // namespace psplit::core
