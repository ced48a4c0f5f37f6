#include "tools/gltf_psplit/report/number_text.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace psplit {

std::string with_separators(uint64_t count) {
  std::string text = std::to_string(count);
  for (size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ',');
  return text;
}

std::string with_decimals(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string with_digits(double value, int digits) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

std::string as_percent(double fraction) {
  std::string text = with_decimals(100 * fraction, 1);
  if (fraction >= 0) text.insert(text.begin(), '+');
  text += " %";
  return text;
}
std::string as_share(double fraction) { return with_decimals(100 * fraction, 1) + " %"; }

std::string as_duration(double ms) {
  if (ms < 100) return with_decimals(ms, 1) + " ms";
  if (ms < 1000) return with_decimals(ms, 0) + " ms";
  return with_decimals(ms / 1000, 2) + " s";
}

std::string as_bytes(uint64_t bytes) {
  if (bytes < 1000) return counted(bytes, "byte");
  double value = static_cast<double>(bytes) / 1000;
  size_t unit = 0;
  constexpr std::array kUnits = {"kB", "MB", "GB", "TB", "PB", "EB"};
  // 999.6 rounds to 1000, which has four digits.
  for (; value >= 999.5 && unit + 1 < kUnits.size(); ++unit) value /= 1000;
  const int decimals = value < 9.995 ? 2 : value < 99.95 ? 1 : 0;
  return with_decimals(value, decimals) + " " + kUnits[unit];
}

std::string plural(const std::string& noun) {
  const bool hisses = noun.ends_with("ch") || noun.ends_with("sh") || noun.ends_with("s");
  return noun + (hisses ? "es" : "s");
}
std::string counted(uint64_t count, const std::string& noun) {
  return count == 1 ? "1 " + noun : with_separators(count) + " " + plural(noun);
}

std::string describe_place(uint64_t mesh, uint64_t primitive) {
  return "mesh " + std::to_string(mesh) + ", primitive " + std::to_string(primitive);
}

}  // namespace psplit
