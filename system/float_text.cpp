#include "system/float_text.h"

#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <string_view>

namespace psplit {
namespace {

bool begins_with_word(const char* at, const char* end, std::string_view word) {
  for (const char c : word)
    if (at == end || (*at++ | 0x20) != c) return false;
  return true;
}

const char* skip_digits(const char* at, const char* end) {
  while (at != end && *at >= '0' && *at <= '9') ++at;
  return at;
}

// Where the number at the front of the text ends; `begin` if there is none.
const char* end_of_number(const char* begin, const char* end) {
  const char* const whole = begin + (begin != end && *begin == '-' ? 1 : 0);
  const char* at = skip_digits(whole, end);
  auto digits = at - whole;
  if (at != end && *at == '.') {
    const char* const fraction = at + 1;
    const char* const after = skip_digits(fraction, end);
    digits += after - fraction;
    if (digits > 0) at = after;
  }
  if (digits == 0) return begin;
  if (at == end || (*at | 0x20) != 'e') return at;
  const char* exponent = at + 1;
  if (exponent != end && (*exponent == '-' || *exponent == '+')) ++exponent;
  const char* const after = skip_digits(exponent, end);
  return after == exponent ? at : after;
}

template <typename T>
std::from_chars_result read_by_stream(const char* begin, const char* end, T& value) {
  const char* const at = begin + (begin != end && *begin == '-' ? 1 : 0);
  for (const auto& [word, number] :
       {std::pair<std::string_view, T>{"infinity", std::numeric_limits<T>::infinity()},
        {"inf", std::numeric_limits<T>::infinity()},
        {"nan", std::numeric_limits<T>::quiet_NaN()}})
    if (begins_with_word(at, end, word)) {
      value = at == begin ? number : -number;
      return {at + word.size(), {}};
    }
  const char* const stop = end_of_number(begin, end);
  if (stop == begin) return {begin, std::errc::invalid_argument};
  const std::string_view text(begin, static_cast<size_t>(stop - begin));
  std::istringstream stream{std::string(text)};
  stream.imbue(std::locale::classic());
  T number{};
  const bool fits = static_cast<bool>(stream >> number);
  // Libraries disagree about numbers that are too small: they become zero, or they are a failure.
  const std::string_view digits = text.substr(0, text.find_first_of("eE"));
  const bool is_zero = digits.find_first_of("123456789") == std::string_view::npos;
  if (!fits || (number == 0 && !is_zero)) return {stop, std::errc::result_out_of_range};
  value = number;
  return {stop, {}};
}

template <typename T>
std::from_chars_result read(const char* begin, const char* end, T& value) {
#ifdef __cpp_lib_to_chars
  return std::from_chars(begin, end, value);
#else
  return read_by_stream(begin, end, value);
#endif
}

}  // namespace

std::from_chars_result read_float(const char* begin, const char* end, float& value) {
  return read(begin, end, value);
}
std::from_chars_result read_float(const char* begin, const char* end, double& value) {
  return read(begin, end, value);
}
std::from_chars_result read_float_by_stream(const char* begin, const char* end, float& value) {
  return read_by_stream(begin, end, value);
}
std::from_chars_result read_float_by_stream(const char* begin, const char* end, double& value) {
  return read_by_stream(begin, end, value);
}

}  // namespace psplit
