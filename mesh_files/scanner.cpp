#include "mesh_files/scanner.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "mesh_files/plain_numbers.h"
#include "system/float_text.h"

namespace psplit {
namespace {

constexpr size_t kWindow = size_t{1} << 20;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
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
