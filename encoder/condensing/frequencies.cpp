#include "encoder/condensing/frequencies.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <queue>

#include "src/core/condensed/models.h"

namespace psplit {
namespace {

// Logarithms to base 2 of the numbers up to 4096, equal on every machine: libm's logarithms differ in their
// last bits between machines, and the bytes of a container must not.
class Logarithms {
 public:
  Logarithms() {
    for (uint32_t x = 1; x < table_.size(); ++x) table_[x] = logarithm(x);
  }
  double operator[](uint32_t x) const { return table_[x]; }

 private:
  // Each square of the mantissa shows one bit more of the fraction.
  static double logarithm(uint32_t x) {
    const int whole = static_cast<int>(std::bit_width(x)) - 1;
    uint64_t mantissa = uint64_t{x} << (31 - whole);
    double result = whole, place = 0.5;
    for (int i = 0; i < 24; ++i, place /= 2) {
      mantissa = mantissa * mantissa >> 31;
      if (mantissa >> 32 == 0) continue;
      mantissa >>= 1;
      result += place;
    }
    return result;
  }
  std::array<double, core::kSlots + 1> table_{};
};

}  // namespace

std::vector<uint16_t> fitting_frequencies(std::span<const uint64_t> counts) {
  std::vector<uint16_t> frequencies(counts.size());
  const uint64_t total = std::accumulate(counts.begin(), counts.end(), uint64_t{0});
  if (total == 0) return frequencies;
  int64_t left = core::kSlots;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    const double exact = static_cast<double>(counts[i]) * core::kSlots / static_cast<double>(total);
    frequencies[i] = static_cast<uint16_t>(std::max(1.0, exact));
    left -= frequencies[i];
  }
  // One more or one less for the symbol that gains most or loses least by it. A symbol's bits change by its
  // count times the change of a logarithm, which is about 2 / (f + f').
  using Change = std::pair<double, size_t>;
  const auto change = [&](size_t i, int by) {
    return Change(static_cast<double>(counts[i]) / (2 * frequencies[i] + by), i);
  };
  std::priority_queue<Change> gains;
  std::priority_queue<Change, std::vector<Change>, std::greater<>> losses;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    if (left > 0) gains.push(change(i, 1));
    if (left < 0 && frequencies[i] > 1) losses.push(change(i, -1));
  }
  for (; left > 0; --left) {
    const size_t i = gains.top().second;
    gains.pop();
    ++frequencies[i];
    gains.push(change(i, 1));
  }
  for (; left < 0; ++left) {
    const size_t i = losses.top().second;
    losses.pop();
    if (--frequencies[i] > 1) losses.push(change(i, -1));
  }
  return frequencies;
}

double coded_bits(std::span<const uint64_t> counts, std::span<const uint16_t> frequencies) {
  static const Logarithms kLogarithms;
  double bits = 0;
  for (size_t i = 0; i < counts.size(); ++i)
    if (counts[i] > 0)
      bits += static_cast<double>(counts[i]) * (kLogarithms[core::kSlots] - kLogarithms[frequencies[i]]);
  return bits;
}

uint32_t fitting_probability(uint64_t zeros, uint64_t ones) {
  const double total = std::max(static_cast<double>(zeros) + static_cast<double>(ones), 1.0);
  const double nearest = static_cast<double>(ones) * core::kSlots / total + 0.5;
  return std::clamp(static_cast<uint32_t>(nearest), 1u, core::kSlots - 1);
}

}  // namespace psplit
