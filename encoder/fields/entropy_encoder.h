// Encoders of flags, symbols and numbers that write the same bytes as libdraco's encoder. The core has their
// decoders (rans.h, symbols.h).
//
// J. Duda: Asymmetric numeral systems, 2013. The formats are those of the Draco bitstream specification 2.2.
// The choices of libdraco's encoder (which coding, which precision, which probabilities) are in its folder
// compression/entropy.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

// The levels of libdraco's encoder, 0 to 10, and one for its versions before 1.2.5, which had no levels.
inline constexpr int kLevelBeforeLevels = 11;
// The level of symbols that are not an attribute's.
inline constexpr int kDefaultSymbolLevel = 7;

// Writes a number of 32 bits, little-endian.
inline void append_u32(uint32_t value, std::vector<uint8_t>& out) {
  for (uint32_t i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(value >> 8 * i));
}

// Writes the number of bytes of a block, and the block.
void append_block(std::span<const uint8_t> block, std::vector<uint8_t>& out);

// Writes flags, each a byte, as bits that share one probability.
void encode_flags(std::span<const uint8_t> flags, std::vector<uint8_t>& out);

// A symbol that occurs. Tables of them are in the order of symbols.
struct SymbolCount {
  uint32_t symbol = 0;
  uint32_t frequency = 0;
  uint32_t prob = 0;   // as a part of 1 << precision
  uint32_t first = 0;  // the sum of the probabilities of all lower symbols
};

// Symbols in groups of `components`, which divides their number, on their way into a stream. The symbols must
// outlive it.
class CountedSymbols {
 public:
  CountedSymbols(std::span<const uint32_t> symbols, uint32_t components);

  // As encode_symbols.
  size_t write(int level, std::vector<uint8_t>& out) const;
  // How many bytes write() writes, up to 3 % and 64 bytes, in much less time.
  size_t estimate(int level) const;

 private:
  uint32_t symbol_bits(int level) const;

  const std::span<const uint32_t> symbols_;
  const uint32_t components_;
  std::vector<uint32_t> tags_;  // the bits of the largest value of each group
  uint32_t max_symbol_ = 0;
  size_t value_bytes_ = 0;  // of tagged symbols
  bool is_tagged_ = false;
  std::vector<SymbolCount> entries_{};  // of tags, or of symbols
};

// Writes symbols in groups of `components`, which divides their number, with the coding that libdraco's encoder
// takes at this level. Writes nothing if there are no symbols. Symbols that libdraco's encoder cannot write are
// tagged, which every decoder reads: more than 2^18 - 1 different ones, or symbols of 32 bits. Returns how many
// of the bytes are a table of probabilities.
size_t encode_symbols(std::span<const uint32_t> symbols, uint32_t components, int level,
                      std::vector<uint8_t>& out);

// The levels, a bit for each, at which libdraco's encoder writes `symbol_bits` to a stream of these symbols
// with the raw coding. That byte is the only effect of the level; the precision follows from it.
uint32_t possible_symbol_levels(std::span<const uint32_t> symbols, uint32_t symbol_bits);

}  // namespace psplit
