// Numbers of text as nearly all files write them, in a fraction of the time that others take.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace psplit {

// These functions return the end of the number, or null if it is not a plain one: then it is for parse_float,
// parse_precise or parse_integer (scanner.h). What follows the number is not looked at.

// Digits with at most one point, sign and exponent, which make 18 digits and 2^53 at most. The double is the
// nearest one, and the float nearest to it is the one nearest to the number.
const char* parse_plain_double(const char* at, const char* end, double& value);
inline const char* parse_plain_float(const char* at, const char* end, float& value) {
  double wide = 0;
  at = parse_plain_double(at, end, wide);
  value = static_cast<float>(wide);
  return at;
}

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Eight characters in one word, the first in the lowest byte, as on every host of this library. Returns how
// many digits they begin with, and the number that these make.
struct DigitsOfWord {
  unsigned count;
  uint32_t number;
};
inline constexpr unsigned kDigitsOfWord = 8;
inline DigitsOfWord digits_of_word(const char* at) {
  uint64_t word;
  std::memcpy(&word, at, sizeof word);
  word ^= 0x3030303030303030u;  // digits become 0 to 9
  // The highest bit of a byte that is more than 9. A carry reaches bytes after the first of these only.
  const uint64_t others = (word | (word + 0x7676767676767676u)) & 0x8080808080808080u;
  const unsigned count = static_cast<unsigned>(std::countr_zero(others)) / 8;
  if (count == 0) return {0, 0};
  // Zeros before the digits make eight of them. Neighbours join: to two digits, to four, to eight.
  word <<= 64 - 8 * count;
  word = word * 10 + (word >> 8);
  constexpr uint64_t kPairs = 0x000000ff000000ffu;
  word = ((word & kPairs) * (100 + (uint64_t{1000000} << 32)) +
          ((word >> 16) & kPairs) * (1 + (uint64_t{10000} << 32))) >>
         32;
  return {count, static_cast<uint32_t>(word)};
}

// Up to nine digits.
inline const char* parse_plain_integer(const char* at, const char* end, uint32_t& value) {
  constexpr ptrdiff_t kMostDigits = 9;
  const char* const begin = at;
  value = 0;
  if (end - at >= ptrdiff_t{kDigitsOfWord}) {
    const DigitsOfWord of_word = digits_of_word(at);
    value = of_word.number;
    at += of_word.count;
    if (of_word.count < kDigitsOfWord) return of_word.count == 0 ? nullptr : at;
  }
  for (; at != end && is_digit(*at) && at - begin <= kMostDigits; ++at)
    value = 10 * value + static_cast<uint32_t>(*at - '0');
  return at == begin || at - begin > kMostDigits ? nullptr : at;
}

}  // namespace psplit
