// The numbers of a condensed stream: plain bits of its first section.
#pragma once

#include "src/core/condensed/condensed_stream.h"
#include "src/core/stitch_codes.h"

namespace psplit::core {

// The kinds of numbers, with their initial orders.
struct CondensedKinds {
  NumberKind count{0}, vertices{0}, splits{2}, event{8}, bytes{8}, low{12}, extent{12}, flags{8}, border{5};
};

// The number of bits in which a stream says which of the attribute's sets of token tables it uses.
PSPLIT_HD inline uint32_t set_bits(const AttributeModel& model) {
  return model.set_count > 1 ? floor_log2(model.set_count - 1u) + 1 : 0;
}

// Reads numbers. Once a number is invalid or beyond the end of the bits, broken() stays set.
class CondensedNumbers {
 public:
  PSPLIT_HD explicit CondensedNumbers(const SectionReader& bits) : bits_(bits) {}

  PSPLIT_HD bool broken() const { return broken_; }
  PSPLIT_HD uint64_t place() const { return bits_.bits_taken(); }

  PSPLIT_HD uint32_t number(NumberKind& kind) {
    uint32_t value;
    broken_ |= !read_number(bits_, kind, value) || !justify(0);
    return value;
  }
  PSPLIT_HD int64_t signed_number(NumberKind& kind) { return unfold(number(kind)); }
  PSPLIT_HD uint32_t bit() { return bits(1); }
  // `count` is at most 32.
  PSPLIT_HD uint32_t bits(int count) {
    const uint32_t value = bits_.read(count);
    broken_ |= !justify(0);
    return value;
  }
  PSPLIT_HD void skip(uint64_t bit_count) {
    broken_ |= !justify(bit_count);
    if (!broken_) bits_.go_to_bit(place() + bit_count);
  }
  // Whether there are this many bits to come.
  PSPLIT_HD bool justify(uint64_t bit_count) const { return bits_.has_bits(place() + bit_count); }

  // The numbers of a split event, as Draco's stream has them.
  struct SplitEventNumbers {
    uint32_t source_delta, back, right_edge;
  };
  PSPLIT_HD SplitEventNumbers split_event(NumberKind& kind) {
    const uint32_t source_delta = number(kind), back = number(kind);
    return {source_delta, back, bit()};
  }

 private:
  SectionReader bits_;
  bool broken_ = false;
};

}  // namespace psplit::core
