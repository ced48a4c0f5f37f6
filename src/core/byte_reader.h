// Readers of a stream, from front to back, by bytes or by bits. All numbers are little-endian.
#pragma once

#include "src/core/view.h"

namespace psplit::core {

// Reads past the end return 0 and set truncated(), which stays set.
class ByteReader {
 public:
  ByteReader() = default;
  PSPLIT_HD ByteReader(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  PSPLIT_HD bool truncated() const { return truncated_; }
  PSPLIT_HD size_t remaining() const { return size_ - at_; }
  PSPLIT_HD const uint8_t* head() const { return data_ + at_; }
  // The number of bytes before head(), which a reader that goes backwards may touch.
  PSPLIT_HD size_t position() const { return at_; }

  PSPLIT_HD bool skip(uint64_t count) {
    if (count > remaining()) {
      truncated_ = true;
      at_ = size_;
      return false;
    }
    at_ += static_cast<size_t>(count);
    return true;
  }

  PSPLIT_HD uint8_t u8() { return at_ < size_ ? data_[at_++] : (truncated_ = true, uint8_t{0}); }

  PSPLIT_HD uint32_t u16() {
    const uint32_t low = u8();
    return low | static_cast<uint32_t>(u8()) << 8;
  }

  PSPLIT_HD uint32_t u32() {
    const uint32_t low = u16();
    return low | u16() << 16;
  }

  PSPLIT_HD float f32() {
    const uint32_t bits = u32();
    float value;
    copy_bytes(&value, &bits, sizeof value);
    return value;
  }

  // LEB128 of at most five bytes. Bits above the 32nd are dropped.
  PSPLIT_HD uint32_t varint() { return static_cast<uint32_t>(leb128(5)); }
  // LEB128 of at most ten bytes, for the lengths that Draco writes with 64 bits.
  PSPLIT_HD uint64_t varint64() { return leb128(10); }

 private:
  PSPLIT_HD uint64_t leb128(int max_bytes) {
    uint64_t value = 0;
    for (int i = 0; i < max_bytes; ++i) {
      const uint8_t byte = u8();
      value |= static_cast<uint64_t>(byte & 0x7f) << (7 * i);
      if (byte < 0x80) return value;
    }
    truncated_ = true;
    return 0;
  }

  const uint8_t* data_ = nullptr;
  size_t size_ = 0, at_ = 0;
  bool truncated_ = false;
};

PSPLIT_HD inline uint64_t load_le64(const uint8_t* bytes) {
  uint64_t value;
  copy_bytes(&value, bytes, sizeof value);
  return value;
}
PSPLIT_HD inline uint32_t load_le32(const uint8_t* bytes) {
  uint32_t value;
  copy_bytes(&value, bytes, sizeof value);
  return value;
}

// load_le64. A device loads aligned words: they begin up to three bytes before the value, and end at most
// kMostBeyond bytes after it.
inline constexpr uint64_t kMostBeyond = PSPLIT_MOVES_ROWS ? 4 : 0;
PSPLIT_HD inline uint64_t load_words(const uint8_t* bytes) {
  if constexpr (!PSPLIT_MOVES_ROWS) return load_le64(bytes);
  const auto at = reinterpret_cast<uintptr_t>(bytes);
  const uint32_t before = static_cast<uint32_t>(at) & 3, shift = 8 * before;
#if defined(__CUDA_ARCH__)
  const auto* const words = reinterpret_cast<const uint32_t*>(at & ~uintptr_t{3});
  const uint32_t middle = words[1];
  return uint64_t{__funnelshift_r(middle, words[2], shift)} << 32 | __funnelshift_r(words[0], middle, shift);
#else
  const uint64_t low = load_le64(bytes - before) >> shift, high = load_le32(bytes - before + 8);
  return before == 0 ? low : low | high << (64 - shift);
#endif
}

// Reads bits, each byte from its lowest bit. Past the end all bits are 0, as in libdraco.
class BitReader {
 public:
  BitReader() = default;
  PSPLIT_HD BitReader(const uint8_t* data, size_t size) : next_(data), end_(data + size) {}

  // Returns at least `count` of the next bits, up to 56, and does not take them.
  PSPLIT_HD uint64_t peek(int count) {
    if (PSPLIT_UNLIKELY(filled_ < count)) refill();
    return bits_;
  }
  // The bits that were peeked and not taken.
  PSPLIT_HD uint64_t peeked() const { return bits_; }
  // `count` is at most what was peeked.
  PSPLIT_HD void take(int count) {
    bits_ >>= count;
    filled_ -= count;
    taken_ += static_cast<uint64_t>(count);
  }
  // `count` is at most 32.
  PSPLIT_HD uint32_t read(int count) {
    const uint64_t mask = (uint64_t{1} << count) - 1;
    const auto value = static_cast<uint32_t>(peek(count) & mask);
    take(count);
    return value;
  }
  PSPLIT_HD uint64_t bits_taken() const { return taken_; }
  // The number of bytes that hold the taken bits.
  PSPLIT_HD uint64_t bytes_taken() const { return (taken_ + 7) / 8; }

 private:
  PSPLIT_HD void refill() {
    if (PSPLIT_LIKELY(end_ - next_ >= static_cast<ptrdiff_t>(8 + kMostBeyond))) {
      bits_ |= load_words(next_) << filled_;
      const int bytes = (63 - filled_) / 8;
      next_ += bytes;
      filled_ += bytes * 8;
      return;
    }
    while (filled_ <= 56) {
      if (next_ < end_) bits_ |= static_cast<uint64_t>(*next_++) << filled_;
      filled_ += 8;
    }
  }

  const uint8_t* next_ = nullptr;
  const uint8_t* end_ = nullptr;
  uint64_t bits_ = 0, taken_ = 0;
  int filled_ = 0;
};

}  // namespace psplit::core
