// Unsigned LEB128 of 32 bits: seven bits a byte, the lowest first, the top bit set on all but the last.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace psplit {

inline void append_varint(std::vector<uint8_t>& bytes, uint32_t value) {
  for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<uint8_t>(value | 0x80));
  bytes.push_back(static_cast<uint8_t>(value));
}

class VarintReader {
 public:
  explicit VarintReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  size_t remaining() const { return bytes_.size(); }

  // Nothing where the bytes end first or the value takes more than 32 bits; every read after that fails too.
  std::optional<uint32_t> read() {
    uint32_t value = 0;
    for (uint32_t shift = 0; shift < 35 && !bytes_.empty(); shift += 7) {
      const uint8_t byte = bytes_.front();
      bytes_ = bytes_.subspan(1);
      if (shift == 28 && byte > 0x0f) break;
      value |= static_cast<uint32_t>(byte & 0x7f) << shift;
      if (byte < 0x80) return value;
    }
    bytes_ = {};
    return std::nullopt;
  }

 private:
  std::span<const uint8_t> bytes_;
};

}  // namespace psplit
