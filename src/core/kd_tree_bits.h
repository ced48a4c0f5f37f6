// The bits of a kD-tree: plain ones, and the three codings of the numbers of points.
#pragma once

#include "src/core/rans.h"

namespace psplit::core {

// Bits that are stored as they are, in words of 32 bits, each from its highest bit.
class PlainBits {
 public:
  PSPLIT_HD Fault start(ByteReader& reader) {
    const uint32_t size = reader.u32();
    words_ = reader.head();
    if (!reader.skip(size) || reader.truncated()) return Fault::kTruncated;
    if (size == 0 || size % 4 != 0) return Fault::kEntropy;
    left_ = uint64_t{8} * size;
    return Fault::kNone;
  }

  // Reads a number of `count` bits, 1 to 32, the highest first. Returns false, and leaves `value` and all bits,
  // if fewer are left.
  PSPLIT_HD bool read(uint32_t count, uint32_t& value) {
    if (count > left_) return false;
    // The bits are in this word, and perhaps in the next one.
    const uint32_t used = static_cast<uint32_t>(0 - left_) % 32;
    uint64_t bits = uint64_t{load_le32(words_)} << 32;
    if (used + count > 32) bits |= load_le32(words_ + 4);
    value = static_cast<uint32_t>(bits << used >> (64 - count));
    if (used + count >= 32) words_ += 4;
    left_ -= count;
    return true;
  }

 private:
  const uint8_t* words_ = nullptr;
  uint64_t left_ = 0;
};

// How numbers are coded. Each level of compression has one of them.
enum class NumberCoding : uint8_t {
  kPlain,
  kRans,    // each bit by rABS, all with the same probability
  kFolded,  // each bit by rABS, with the probability of its place in the number
};

class TreeNumbers {
 public:
  static constexpr uint32_t kPlaces = 32;

  PSPLIT_HD Fault start(ByteReader& reader, NumberCoding coding) {
    coding_ = coding;
    if (coding == NumberCoding::kPlain) return plain_.start(reader);
    const uint32_t places = coding == NumberCoding::kRans ? 1 : kPlaces;
    for (uint32_t i = 0; i < places; ++i)
      if (const Fault fault = places_[i].start(reader); fault != Fault::kNone) return fault;
    if (coding == NumberCoding::kRans) return Fault::kNone;
    RansBits single;  // unused: all bits belong to numbers
    return single.start(reader);
  }

  // Reads a number of `count` bits, 1 to 32, the highest first. It is 0 if plain bits end.
  PSPLIT_HD uint32_t read(uint32_t count) {
    uint32_t value = 0;
    switch (coding_) {
      case NumberCoding::kPlain: (void)plain_.read(count, value); break;
      case NumberCoding::kRans:
        for (; count > 0; --count) value = value << 1 | static_cast<uint32_t>(places_[0].next());
        break;
      case NumberCoding::kFolded:
        for (uint32_t i = 0; i < count; ++i) value = value << 1 | static_cast<uint32_t>(places_[i].next());
        break;
    }
    return value;
  }

 private:
  NumberCoding coding_ = NumberCoding::kPlain;
  PlainBits plain_;
  RansBits places_[kPlaces];
};

}  // namespace psplit::core
