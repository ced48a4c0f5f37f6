// SHA-256 (FIPS 180-4): names for content, and the proof that it is still the same.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace psplit {

class Sha256 {
 public:
  void add(std::span<const uint8_t> bytes);
  void add(std::string_view text);
  // The length before the bytes: what is added this way cannot run into what follows.
  void add_framed(std::span<const uint8_t> bytes);
  void add_framed(std::string_view text);
  // 64 hexadecimal digits. Nothing may be added afterwards.
  std::string hex();

 private:
  void add_block(const uint8_t* block);

  std::array<uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                    0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<uint8_t, 64> pending_{};
  uint64_t byte_count_ = 0;
};

}  // namespace psplit
