// Which parallelograms libdraco's encoder uses for a value of the constrained multi-parallelogram scheme.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "src/core/prediction_data.h"

namespace psplit {

// The symbols so far, by their frequencies, and how many bits an entropy coder would need for them. A sum over
// all symbols is kept up to date.
//
// The sum decides which parallelograms are used, so its bits decide the stream's. It is a double that libdraco
// changes by the difference of two products, each of a frequency and its logarithm, in the order of the
// symbols; no multiply-add is fused. The logarithm is the C library's log2, as in libdraco: a library that
// rounds it otherwise may choose otherwise, and then writes another stream, which is as valid.
class SymbolEntropy {
 public:
  struct Total {
    double sum = 0;  // of frequency * log2(frequency)
    uint32_t largest = 0, different = 0;
  };

  // The total with more symbols, which are not added.
  Total with(const uint32_t* symbols, uint32_t count) {
    Total total = total_;
    for (uint32_t k = 0; k < count; ++k) {
      uint32_t frequency = frequency_of(symbols[k]);
      for (uint32_t before = 0; before < k; ++before) frequency += symbols[before] == symbols[k] ? 1 : 0;
      if (frequency == 0) {
        ++total.different;
        if (symbols[k] > total.largest) total.largest = symbols[k];
      }
      total.sum += term(frequency + 1) - term(frequency);
    }
    return total;
  }
  // Adds symbols whose total is `total`.
  void add(const uint32_t* symbols, uint32_t count, const Total& total) {
    for (uint32_t k = 0; k < count; ++k) ++place_of(symbols[k]);
    total_ = total;
    count_ += count;
  }
  uint32_t count() const { return count_; }

 private:
  static constexpr uint32_t kDirect = 1u << 16;  // symbols below have a place of their own
  struct Slot {
    uint32_t symbol = 0, frequency = 0;
  };

  uint32_t frequency_of(uint32_t symbol) const {
    if (symbol < kDirect) return symbol < direct_.size() ? direct_[symbol] : 0;
    return slots_.empty() ? 0 : slots_[find_slot(symbol)].frequency;
  }
  uint32_t& place_of(uint32_t symbol);
  // The symbol's slot, or the empty one that it would get.
  size_t find_slot(uint32_t symbol) const {
    constexpr uint32_t kFactor = 2654435769u;  // Fibonacci hashing
    size_t at = symbol * kFactor >> (32 - std::countr_zero(slots_.size()));
    while (slots_[at].symbol != symbol && slots_[at].frequency != 0) at = (at + 1) & (slots_.size() - 1);
    return at;
  }
  double term(uint32_t frequency) {
    return frequency < terms_.size() ? terms_[frequency] : add_terms(frequency);
  }
  double add_terms(uint32_t frequency);

  Total total_;
  uint32_t count_ = 0;
  std::vector<uint32_t> direct_;
  std::vector<Slot> slots_;  // of larger symbols, by hash; their number is 0 or a power of two
  uint32_t used_slots_ = 0;
  std::vector<double> terms_;
};

// Chooses for one value after the other, from the last of the sequence to the second.
class CreaseChoice {
 public:
  explicit CreaseChoice(uint32_t components)
      : components_(components), residual_(components), symbols_(components), best_symbols_(components) {}

  // The values that predict one, as wide as a value: the one before it, and `count` parallelograms, components
  // after components.
  struct Choice {
    uint32_t used = 0;               // a bit for each parallelogram
    std::vector<int32_t> predicted;  // the mean of the used parallelograms, or the value before
  };
  const Choice& choose(const int32_t* value, const int32_t* before, const int32_t* parallelograms,
                       uint32_t count);

 private:
  struct Cost {
    int32_t bits = 0, size = 0;  // the sum of magnitudes decides between equal bits
  };
  void consider(const int32_t* value, const int32_t* predicted, uint32_t used, int64_t flag_bits,
                bool is_first);

  uint32_t components_;
  SymbolEntropy entropy_;
  // By the number of parallelograms of a value: how many there were, and how many were used.
  std::array<int64_t, core::kMaxParallelograms> total_{}, used_{};
  std::vector<int32_t> residual_;
  std::vector<uint32_t> symbols_, best_symbols_;
  std::vector<int32_t> mean_;
  Cost best_;
  SymbolEntropy::Total best_total_;
  double scaled_log_ = 0;  // of the number of symbols, the value's included
  Choice choice_;
};

}  // namespace psplit
