// Bit codes of numbers: for stitch maps, shared by their reader and writer, and for condensed streams.
// Specification: "numbers" and "stitch map" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/platform.h"

namespace psplit::core {

// Maps a signed number near 0 to a small unsigned number, and back.
PSPLIT_HD constexpr uint64_t fold(int64_t value) {
  return value < 0 ? static_cast<uint64_t>(-value) * 2 - 1 : static_cast<uint64_t>(value) * 2;
}
PSPLIT_HD constexpr int64_t unfold(uint32_t value) {
  return value % 2 == 0 ? int64_t{value / 2} : -int64_t{value / 2} - 1;
}

// Numbers of one kind have exponential Golomb codes. The order of the code follows the numbers: after small
// numbers, small numbers take few bits.
class NumberKind {
 public:
  PSPLIT_HD explicit NumberKind(uint32_t order) : sixteenths_(16 * order) {}

  PSPLIT_HD uint32_t order() const { return sixteenths_ / 16; }
  PSPLIT_HD void follow(uint32_t value) { sixteenths_ = (3 * sixteenths_ + 16 * floor_log2(value)) / 4; }

 private:
  uint32_t sixteenths_;
};

// Reads a number of a kind. `bits` is a reader with peek, take and read, such as BitReader. Returns false if
// the code is invalid, or if the number needs more than 32 bits.
template <typename Bits>
PSPLIT_HD bool read_number(Bits& bits, NumberKind& kind, uint32_t& value) {
  const uint64_t ahead = bits.peek(33) & 0x1ffffffffu;
  const uint32_t order = kind.order();
  const uint32_t zeros = ahead == 0 ? 33 : trailing_zeros(ahead);
  value = 0;
  if (zeros + order > 32) return false;
  bits.take(static_cast<int>(zeros) + 1);
  const uint64_t high = (uint64_t{1} << zeros) - 1 + bits.read(static_cast<int>(zeros));
  const uint64_t whole = high << order | bits.read(static_cast<int>(order));
  value = static_cast<uint32_t>(whole);
  kind.follow(value);
  return whole <= 0xffffffffu;
}

// The kinds of numbers in a stream's part of the map, with their initial orders.
struct StitchKinds {
  PSPLIT_HD StitchKinds(uint32_t point_count, uint32_t reference_count)
      : place(point_count < 2 ? 0 : floor_log2(point_count) - 1),
        point_skip(reference_count == 0 ? 0 : floor_log2(point_count / reference_count)) {}

  NumberKind count{0}, back{0};
  NumberKind walk_skip{1}, length{1}, start_step{2};  // for runs
  NumberKind place;                                   // in a walk, or among the points that a stream owns
  NumberKind point_skip, distance{1}, rank_step{1};   // for repeats and pairs
};

// Predicts where a run starts in its owner's walk: runs of one owner follow each other there as they do in this
// walk, with about as many places between them.
class ExpectedStart {
 public:
  ExpectedStart() = default;
  // The start that is expected after a run of the same owner.
  PSPLIT_HD ExpectedStart(uint32_t start, uint32_t length, bool forward)
      : next_(forward ? int64_t{start} + length : int64_t{start} - length), sign_(forward ? 1 : -1) {}

  // The start of a run that begins `skip` places after the last one. `step` is the error of the prediction as
  // it was read, so the start may be any number.
  PSPLIT_HD int64_t start(uint32_t skip, int64_t step) const { return next_ + sign_ * (skip + step); }
  PSPLIT_HD int64_t step(uint32_t skip, uint32_t start) const { return sign_ * (start - next_) - skip; }

 private:
  int64_t next_ = 0, sign_ = -1;
};

// Predicts ranks of one owner: the next rank is one from the last, in the same direction.
class ExpectedRank {
 public:
  PSPLIT_HD int64_t rank(int64_t step) const { return last_ + sign_ * (1 + step); }
  PSPLIT_HD int64_t step(uint32_t rank) const { return sign_ * (rank - last_) - 1; }
  PSPLIT_HD void follow(uint32_t rank) {
    sign_ = rank < last_ ? -1 : 1;
    last_ = rank;
  }
  // The first rank of an owner says nothing about the direction.
  PSPLIT_HD void begin(uint32_t rank) { last_ = rank; }

 private:
  int64_t last_ = 0, sign_ = -1;
};

}  // namespace psplit::core
