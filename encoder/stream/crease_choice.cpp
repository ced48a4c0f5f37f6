#include "encoder/stream/crease_choice.h"

#include <bit>
#include <cmath>

#include "src/core/integer_vectors.h"
#include "src/core/stitch_codes.h"

namespace psplit {
namespace {

// The sets of used parallelograms of a value in the order in which libdraco tries them, a bit for each: by
// their number; sets of one number so that the later parallelograms are left out first. The first of equal sets
// wins.
struct Sets {
  uint8_t count = 0;
  std::array<uint8_t, 16> sets{};
};
constexpr Sets sets_of(uint32_t parallelograms) {
  Sets all;
  for (int used = 1; used <= static_cast<int>(parallelograms); ++used)
    for (uint32_t left_out = 0; left_out < 1u << parallelograms; ++left_out) {
      uint32_t set = 0;
      for (uint32_t j = 0; j < parallelograms; ++j)
        if ((left_out >> (parallelograms - 1 - j) & 1) == 0) set |= 1u << j;
      if (std::popcount(set) == used) all.sets[all.count++] = static_cast<uint8_t>(set);
    }
  return all;
}
constexpr std::array<Sets, core::kMaxParallelograms + 1> kSets = {sets_of(0), sets_of(1), sets_of(2),
                                                                  sets_of(3), sets_of(4)};

// The bits of `total` flags of which `used` are set, by their entropy. In doubles, and in this order: its bits
// decide the stream's (see SymbolEntropy).
int64_t bits_of_flags(int64_t used, int64_t total) {
  if (used == 0 || used == total) return 0;
  const double set = static_cast<double>(used) / static_cast<double>(total), clear = 1.0 - set;
  const double entropy = -(set * std::log2(set) + clear * std::log2(clear));
  return static_cast<int64_t>(std::ceil(static_cast<double>(total) * entropy));
}

// Of a table of frequencies in the stream. libdraco has 32-bit numbers here, which wrap around at the ends of
// grids of 30 bits.
int32_t bits_of_table(uint32_t largest, uint32_t different) {
  constexpr int32_t kRun = 64;
  const auto runs = static_cast<uint32_t>(static_cast<int32_t>(largest + 1 - different) / kRun);
  return static_cast<int32_t>(8 * (2 * different + runs));
}

}  // namespace

uint32_t& SymbolEntropy::place_of(uint32_t symbol) {
  if (symbol < kDirect) {
    if (symbol >= direct_.size()) direct_.resize(std::bit_ceil(symbol + 1));
    return direct_[symbol];
  }
  constexpr size_t kFirstSlots = 1024;
  if (2 * size_t{used_slots_} >= slots_.size()) {
    std::vector<Slot> old(slots_.empty() ? kFirstSlots : 2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.frequency > 0) slots_[find_slot(slot.symbol)] = slot;
  }
  Slot& slot = slots_[find_slot(symbol)];
  if (slot.frequency == 0) slot.symbol = symbol, ++used_slots_;
  return slot.frequency;
}

double SymbolEntropy::add_terms(uint32_t frequency) {
  constexpr uint32_t kMostTerms = 1u << 16;
  const auto term_of = [](uint32_t number) {
    const auto value = static_cast<double>(number);
    return value * std::log2(value);
  };
  if (frequency >= kMostTerms) return term_of(frequency);
  if (terms_.empty()) terms_ = {0, 0};
  while (terms_.size() <= frequency) terms_.push_back(term_of(static_cast<uint32_t>(terms_.size())));
  return terms_[frequency];
}

void CreaseChoice::consider(const int32_t* value, const int32_t* predicted, uint32_t used, int64_t flag_bits,
                            bool is_first) {
  uint32_t size = 0;
  for (uint32_t k = 0; k < components_; ++k) {
    const int32_t residual = core::wrapping_sub(predicted[k], value[k]);
    size += core::magnitude(residual);
    symbols_[k] = static_cast<uint32_t>(core::fold(residual));
  }
  const SymbolEntropy::Total total = entropy_.with(symbols_.data(), components_);
  const uint32_t count = entropy_.count() + components_;
  const int64_t data_bits = count < 2 ? 0 : static_cast<int64_t>(std::ceil(scaled_log_ - total.sum));
  const Cost cost{static_cast<int32_t>(data_bits + bits_of_table(total.largest, total.different) + flag_bits),
                  static_cast<int32_t>(size)};
  const bool is_better = cost.bits != best_.bits ? cost.bits < best_.bits : cost.size < best_.size;
  if (!is_first && !is_better) return;
  best_ = cost;
  best_total_ = total;
  best_symbols_.swap(symbols_);
  choice_.used = used;
  choice_.predicted.assign(predicted, predicted + components_);
}

const CreaseChoice::Choice& CreaseChoice::choose(const int32_t* value, const int32_t* before,
                                                 const int32_t* parallelograms, uint32_t count) {
  const double symbols = static_cast<double>(entropy_.count() + components_);
  scaled_log_ = symbols * std::log2(symbols);
  std::array<int64_t, core::kMaxParallelograms + 1>
      flag_bits{};  // by the number of parallelograms that are used
  if (count > 0) {
    total_[count - 1] += count;
    for (uint32_t used = 0; used <= count; ++used)
      flag_bits[used] = bits_of_flags(used_[count - 1] + used, total_[count - 1]);
  }
  consider(value, before, 0, flag_bits[0], true);
  mean_.resize(components_);
  const Sets& sets = kSets[count];
  for (uint32_t at = 0; at < sets.count; ++at) {
    const uint32_t set = sets.sets[at];
    const int used = std::popcount(set);
    for (uint32_t k = 0; k < components_; ++k) {
      int32_t sum = 0;
      for (uint32_t j = 0; j < count; ++j)
        if ((set >> j & 1) != 0) sum = core::wrapping_add(sum, parallelograms[j * components_ + k]);
      mean_[k] = sum / used;
    }
    consider(value, mean_.data(), set, flag_bits[static_cast<size_t>(used)], false);
  }
  if (count > 0) used_[count - 1] += std::popcount(choice_.used);
  entropy_.add(best_symbols_.data(), components_, best_total_);
  return choice_;
}

}  // namespace psplit
