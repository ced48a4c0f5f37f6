#include "mesh_files/scanner.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "system/float_text.h"

namespace psplit {
namespace {

constexpr size_t kWindow = size_t{1} << 20;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }
// Control characters are rare, so one comparison with the space settles most characters.
bool is_space(char c) { return static_cast<unsigned char>(c) <= ' ' && (is_blank(c) || is_line_end(c)); }

// Numbers that are not finite, as from_chars does not know them. Older libraries of Microsoft print "1.#INF00",
// "-1.#IND" and "1.#QNAN0", rounded to "1.#J" or with an exponent; others print "nan(ind)" or "NaNQ".
template <typename T>
std::optional<T> parse_not_finite(std::string_view word) {
  constexpr size_t kMostCharacters = 32;
  if (word.size() > kMostCharacters) return std::nullopt;
  std::string text(word);
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const bool is_negative = text.starts_with('-');
  if (is_negative || text.starts_with('+')) text.erase(0, 1);
  const auto are_all = [](std::string_view part, std::string_view others) {
    return std::ranges::all_of(
        part, [&](char c) { return (c >= 'a' && c <= 'z') || is_digit(c) || others.find(c) != others.npos; });
  };
  if (text.starts_with("1.#") && text.size() > 3 && !is_digit(text[3]) && are_all(text.substr(3), "+-")) {
    const T infinite = std::numeric_limits<T>::infinity();
    if (text.starts_with("1.#inf")) return is_negative ? -infinite : infinite;
  } else if (text != "nanq" && text != "nans" &&
             !(text.starts_with("nan(") && text.ends_with(')') &&
               are_all(text.substr(4, text.size() - 5), "_"))) {
    return std::nullopt;
  }
  return std::numeric_limits<T>::quiet_NaN();
}

template <typename T>
std::optional<T> parse_number(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+') word.remove_prefix(1);
  T value{};
  const char* const end = word.data() + word.size();
  const auto [stop, error] = [&] {
    if constexpr (std::is_floating_point_v<T>)
      return read_float(word.data(), end, value);
    else
      return std::from_chars(word.data(), end, value);
  }();
  if (stop != end || word.empty() || error == std::errc::invalid_argument) {
    if constexpr (std::is_floating_point_v<T>) return parse_not_finite<T>(word);
    return std::nullopt;
  }
  if (error == std::errc()) return value;
  if constexpr (std::is_floating_point_v<T>) {
    // Out of range: too large, or so small that it becomes zero.
    if constexpr (std::is_same_v<T, float>)
      if (const std::optional<double> wide = parse_number<double>(word); wide && std::fabs(*wide) < 1)
        return static_cast<float>(*wide);
    if constexpr (std::is_same_v<T, double>)
      if (const size_t exponent = word.find_first_of("eE");
          exponent != std::string_view::npos && word.substr(exponent + 1).starts_with('-'))
        return T{};
  }
  return std::nullopt;
}

}  // namespace

Scanner::Scanner(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)), window_(new char[kWindow]) {}

bool Scanner::fill() {
  if (at_ > 0) {
    std::memmove(window_.get(), window_.get() + at_, end_ - at_);
    offset_ += at_;
    end_ -= at_;
    at_ = 0;
  }
  const std::span<char> room = std::span(window_.get(), kWindow).subspan(end_);
  const size_t got = stream_->read({reinterpret_cast<uint8_t*>(room.data()), room.size()});
  end_ += got;
  return got > 0;
}

std::string_view Scanner::word() {
  for (;; ++at_) {
    if (at_ == end_ && !fill()) return {};
    if (!is_blank(window_[at_])) break;
  }
  if (is_line_end(window_[at_])) return {};
  size_t length = 1;
  for (;; ++length) {
    if (at_ + length == end_ && (length >= kLongestWord || !fill())) break;
    if (is_space(window_[at_ + length]) || length == kLongestWord) break;
  }
  const std::string_view found(window_.get() + at_, length);
  at_ += length;
  return found;
}

void Scanner::end_line() {
  const bool carriage_return = window_[at_++] == '\r';
  if (carriage_return && (at_ < end_ || fill()) && window_[at_] == '\n') ++at_;
  ++line_;
}

std::string_view Scanner::next_word() {
  for (;;) {
    const std::string_view found = word();
    if (!found.empty()) return found;
    if (at_ == end_) return {};  // word() has tried to read more
    end_line();
  }
}

bool Scanner::next_line() {
  const bool more = skip_rest_of_line();
  if (more) end_line();
  return more;
}

bool Scanner::skip_rest_of_line() {
  for (;;) {
    if (at_ == end_ && !fill()) return false;
    const char* const begin = window_.get() + at_;
    const char* const end = window_.get() + end_;
    const char* const found = std::find_if(begin, end, is_line_end);
    at_ += static_cast<size_t>(found - begin);
    if (found != end) return true;
  }
}

std::optional<std::string> Scanner::rest_of_line() {
  std::string text;
  for (;; ++at_) {
    if (at_ == end_ && !fill()) break;
    const char c = window_[at_];
    if (is_line_end(c)) break;
    if (text.empty() && is_blank(c)) continue;
    if (text.size() == kLongestText) return std::nullopt;
    text += c;
  }
  while (!text.empty() && is_blank(text.back())) text.pop_back();
  return text;
}

std::string_view Scanner::peek(size_t count) {
  count = std::min(count, kMostPeeked);
  while (end_ - at_ < count && fill()) {
  }
  return {window_.get() + at_, std::min(count, end_ - at_)};
}

std::string_view Scanner::peek_lines() {
  if (end_ - at_ < kWindow / 2) fill();
  const std::string_view text(window_.get() + at_, end_ - at_);
  return text.substr(0, text.rfind('\n') + 1);
}

void Scanner::skip_lines(size_t bytes, uint64_t line_count) {
  skip(bytes);
  line_ += line_count;
}

void Scanner::skip(size_t count) { at_ += std::min(count, end_ - at_); }

std::optional<uint64_t> Scanner::bytes_left() const {
  const std::optional<uint64_t> size = stream_->size();
  if (!size) return std::nullopt;
  return *size > offset() ? *size - offset() : 0;
}

uint64_t Scanner::drain() {
  const uint64_t begin = offset();
  do at_ = end_;
  while (fill());
  return offset() - begin;
}

namespace {

// Eight characters in one word, the first in the lowest byte, as on every host of this library. Returns how
// many digits they begin with, and the number that these make.
struct DigitsOfWord {
  unsigned count;
  uint32_t number;
};
DigitsOfWord digits_of_word(const char* at) {
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
constexpr unsigned kDigitsOfWord = 8;

// Of a number that parse_plain_float reads, the nearest double.
const char* parse_plain_double(const char* at, const char* end, double& value) {
  // These powers are exact.
  static constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                       1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  static constexpr uint64_t kPowersOfDigits[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
  constexpr int kMostPower = 22, kMostDigits = 18, kMostExponentDigits = 3;
  constexpr uint64_t kMostExact = uint64_t{1} << 53;
  const bool is_negative = at != end && *at == '-';
  if (is_negative) ++at;
  uint64_t digits = 0;
  int power = 0, digit_count = 0;
  const auto read_digits = [&] {
    const char* const begin = at;
    // Two words of digits cannot overflow. Numbers with more digits are refused below.
    for (int words = 0; words < 2 && end - at >= ptrdiff_t{kDigitsOfWord}; ++words) {
      const DigitsOfWord of_word = digits_of_word(at);
      digits = kPowersOfDigits[of_word.count] * digits + of_word.number;
      at += of_word.count;
      if (of_word.count < kDigitsOfWord) break;
    }
    for (; at != end && is_digit(*at); ++at) digits = 10 * digits + static_cast<uint64_t>(*at - '0');
    digit_count += static_cast<int>(std::min<ptrdiff_t>(at - begin, kMostDigits + 1));
    return static_cast<int>(std::min<ptrdiff_t>(at - begin, kMostDigits + 1));
  };
  read_digits();
  if (at != end && *at == '.') {
    ++at;
    power = -read_digits();
  }
  if (digit_count == 0 || digit_count > kMostDigits || digits > kMostExact) return nullptr;
  if (at != end && (*at == 'e' || *at == 'E')) {
    ++at;
    const bool is_below = at != end && *at == '-';
    if (at != end && (*at == '-' || *at == '+')) ++at;
    int exponent = 0, count = 0;
    for (; at != end && is_digit(*at) && count <= kMostExponentDigits; ++at, ++count)
      exponent = 10 * exponent + (*at - '0');
    if (count == 0 || count > kMostExponentDigits) return nullptr;
    power += is_below ? -exponent : exponent;
  }
  if (power < -kMostPower || power > kMostPower) return nullptr;
  // One operation on exact numbers, so that the double is the nearest one.
  const double wide =
      power < 0 ? static_cast<double>(digits) / kPowers[-power] : static_cast<double>(digits) * kPowers[power];
  // The float nearest to it is the one nearest to the number, unless the double is in the middle of two floats:
  // the number may then be on either side.
  constexpr uint64_t kBelowFloat = (uint64_t{1} << 29) - 1, kMiddle = uint64_t{1} << 28;
  if ((std::bit_cast<uint64_t>(wide) & kBelowFloat) == kMiddle) return nullptr;
  if (digits != 0 && !(wide >= double{std::numeric_limits<float>::min()} && wide < 1e38)) return nullptr;
  value = is_negative ? -wide : wide;
  return at;
}

}  // namespace

const char* parse_plain_float(const char* at, const char* end, float& value) {
  double wide = 0;
  at = parse_plain_double(at, end, wide);
  value = static_cast<float>(wide);
  return at;
}

const char* parse_plain_integer(const char* at, const char* end, uint32_t& value) {
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

std::optional<float> parse_float(std::string_view word) {
  const char* const end = word.data() + word.size();
  float value = 0;
  return parse_plain_float(word.data(), end, value) == end ? value : parse_number<float>(word);
}
std::optional<double> parse_double(std::string_view word) { return parse_number<double>(word); }
std::optional<double> parse_precise(std::string_view word) {
  const char* const end = word.data() + word.size();
  double value = 0;
  if (parse_plain_double(word.data(), end, value) == end) return value;
  const std::optional<float> once = parse_number<float>(word);
  const std::optional<double> number = parse_number<double>(word);
  if (!once || !number || std::isnan(*once)) return once ? std::optional(double{*once}) : std::nullopt;
  if (static_cast<float>(*number) == *once) return number;
  const double next = std::nextafter(*number, double{*once});
  return static_cast<float>(next) == *once ? next : double{*once};
}
std::optional<int64_t> parse_integer(std::string_view word) {
  const char* const end = word.data() + word.size();
  uint32_t value = 0;
  return parse_plain_integer(word.data(), end, value) == end ? value : parse_number<int64_t>(word);
}

Status error_at_line(uint64_t line, const std::string& what) {
  return invalid_input("line " + std::to_string(line) + ": " + what);
}

Status error_at_byte(uint64_t offset, const std::string& what) {
  return invalid_input("byte " + std::to_string(offset) + ": " + what);
}

std::string in_quotes(std::string_view word) {
  constexpr size_t kShown = 40;
  std::string text = "\"";
  for (const char c : word.substr(0, kShown)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > kShown ? "...\"" : "\"");
}

}  // namespace psplit
