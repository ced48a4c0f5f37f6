#include "mesh_files/plain_numbers.h"

#include <limits>

namespace psplit {
namespace {

// Two words of digits, which cannot overflow, and the rest one by one. Of more than 18 digits in all, the
// number does not count.
const char* read_digits(const char* at, const char* end, uint64_t& digits) {
  static constexpr uint64_t kPowers[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
  for (int words = 0; words < 2 && end - at >= ptrdiff_t{kDigitsOfWord}; ++words) {
    const DigitsOfWord of_word = digits_of_word(at);
    digits = kPowers[of_word.count] * digits + of_word.number;
    at += of_word.count;
    if (of_word.count < kDigitsOfWord) return at;
  }
  for (; at != end && is_digit(*at); ++at) digits = 10 * digits + static_cast<uint64_t>(*at - '0');
  return at;
}

// From the character after the "e" on. Null if it has no digits, or too many.
const char* read_exponent(const char* at, const char* end, int& exponent) {
  constexpr int kMostDigits = 3;
  const bool is_below = at != end && *at == '-';
  if (at != end && (*at == '-' || *at == '+')) ++at;
  int count = 0;
  for (exponent = 0; at != end && is_digit(*at) && count <= kMostDigits; ++at, ++count)
    exponent = 10 * exponent + (*at - '0');
  if (is_below) exponent = -exponent;
  return count == 0 || count > kMostDigits ? nullptr : at;
}

}  // namespace

const char* parse_plain_double(const char* at, const char* end, double& value) {
  // These powers are exact.
  static constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                       1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  constexpr int kMostPower = 22, kMostDigits = 18;
  constexpr uint64_t kMostExact = uint64_t{1} << 53;
  const bool is_negative = at != end && *at == '-';
  if (is_negative) ++at;
  uint64_t digits = 0;
  int power = 0;
  // Mostly one digit or few are before the point.
  const char* begin = at;
  for (; at != end && is_digit(*at); ++at) digits = 10 * digits + static_cast<uint64_t>(*at - '0');
  ptrdiff_t digit_count = at - begin;
  if (at != end && *at == '.') {
    begin = ++at;
    at = read_digits(at, end, digits);
    digit_count += at - begin;
    power = static_cast<int>(begin - at);
  }
  if (digit_count == 0 || digit_count > kMostDigits || digits > kMostExact) return nullptr;
  if (at != end && (*at | 0x20) == 'e') {
    int exponent = 0;
    at = read_exponent(at + 1, end, exponent);
    power += exponent;
    if (at == nullptr || power < -kMostPower || power > kMostPower) return nullptr;
  }
  // One operation on exact numbers, so that the double is the nearest one.
  const double wide =
      power <= 0 ? static_cast<double>(digits) / kPowers[-power] : static_cast<double>(digits) * kPowers[power];
  // The float nearest to it is the one nearest to the number, unless the double is in the middle of two floats:
  // the number may then be on either side.
  constexpr uint64_t kBelowFloat = (uint64_t{1} << 29) - 1, kMiddle = uint64_t{1} << 28;
  if ((std::bit_cast<uint64_t>(wide) & kBelowFloat) == kMiddle) return nullptr;
  if (digits != 0 && !(wide >= double{std::numeric_limits<float>::min()} && wide < 1e38)) return nullptr;
  value = is_negative ? -wide : wide;
  return at;
}

}  // namespace psplit
