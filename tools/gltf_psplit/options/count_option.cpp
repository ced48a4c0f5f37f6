#include "tools/gltf_psplit/options/count_option.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "system/float_text.h"

namespace psplit {
namespace {

// "1e6", "1.5M", "250k"
std::optional<uint64_t> parse_scaled(std::string_view text) {
  double factor = 1;
  switch (text.back()) {
    case 'k':
    case 'K': factor = 1e3; break;
    case 'm':
    case 'M': factor = 1e6; break;
    case 'g':
    case 'G': factor = 1e9; break;
    default: break;
  }
  if (factor != 1) text.remove_suffix(1);
  if (text.empty() || text.front() < '0' || text.front() > '9') return std::nullopt;  // no sign, no "inf"
  double number = 0;
  const auto read = read_float(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  number *= factor;
  constexpr double kExactIntegers = 9007199254740992;  // 2^53
  const double whole = std::nearbyint(number);
  // 1.1M is a whole number, but in doubles 1.1 * 1e6 is not exactly one.
  if (!(number <= kExactIntegers) || std::abs(whole - number) > 1e-6 * factor) return std::nullopt;
  return static_cast<uint64_t>(whole);
}

}  // namespace

std::optional<uint64_t> parse_count(const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text.find_first_not_of("0123456789_,") != std::string::npos) return parse_scaled(text);
  std::string digits;
  char before = '_';
  for (const char c : text) {
    const bool separates = c == '_' || c == ',';
    if (!separates) digits += c;
    if (separates && (before == '_' || before == ',')) return std::nullopt;
    before = c;
  }
  uint64_t count = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), count);
  const bool ends_with_digit = before != '_' && before != ',';
  return read.ec == std::errc() && ends_with_digit ? std::optional(count) : std::nullopt;
}

std::optional<uint64_t> parse_size(const std::string& text) {
  if (text.empty() || text.front() < '0' || text.front() > '9') return std::nullopt;
  double number = 0;
  const char* const end = text.data() + std::min(text.find_first_not_of("0123456789."), text.size());
  const auto read = read_float(text.data(), end, number);
  if (read.ec != std::errc()) return std::nullopt;
  std::string unit(read.ptr, text.data() + text.size());
  if (unit.starts_with(' ')) unit.erase(0, 1);
  std::ranges::transform(unit, unit.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::string_view kPrefixes = "kmgt";
  const size_t prefix = unit.empty() ? kPrefixes.npos : kPrefixes.find(unit.front());
  if (prefix != kPrefixes.npos) {
    unit.erase(0, 1);
    number = std::ldexp(number, 10 * (static_cast<int>(prefix) + 1));
    if (unit == "ib") unit = "b";
  }
  constexpr double kTooMany = 9223372036854775808.0;  // 2^63
  if ((!unit.empty() && unit != "b") || !(number < kTooMany)) return std::nullopt;
  return static_cast<uint64_t>(number);
}

CLI::Option* add_count_option(CLI::App& command, const std::string& name, uint64_t& count,
                              const std::string& description) {
  constexpr uint64_t kMost = 0xffffffff;
  const auto to_digits = [](std::string& text) {
    const std::optional<uint64_t> parsed = parse_count(text);
    if (!parsed || *parsed < 1 || *parsed > kMost)
      return text + " is not a count from 1 to " + std::to_string(kMost) + ", such as 250000, 250k or 2.5e5";
    text = std::to_string(*parsed);
    return std::string();
  };
  CLI::Option* const option = command.add_option(name, count, description);
  if (count > 0) option->default_str(std::to_string(count));
  return option->transform(CLI::Validator(to_digits, ""))->type_name("N");
}

CLI::Option* add_size_option(CLI::App& command, const std::string& name, uint64_t& bytes,
                             const std::string& description) {
  const auto to_digits = [](std::string& text) {
    const std::optional<uint64_t> parsed = parse_size(text);
    if (!parsed) return text + " is not a size below 2^63 bytes, such as 512MB or 1.5GB";
    text = std::to_string(*parsed);
    return std::string();
  };
  return command.add_option(name, bytes, description)
      ->transform(CLI::Validator(to_digits, ""))
      ->type_name("SIZE");
}

}  // namespace psplit
