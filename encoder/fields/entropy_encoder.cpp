#include "encoder/fields/entropy_encoder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>

#include "src/container/bit_string.h"

namespace psplit {
namespace {

std::vector<SymbolCount> count_symbols(std::span<const uint32_t> symbols, uint32_t max_symbol) {
  std::vector<SymbolCount> entries;
  if (max_symbol < 8 * symbols.size() + 256) {
    std::vector<uint32_t> frequencies(size_t{max_symbol} + 1);
    for (const uint32_t symbol : symbols) ++frequencies[symbol];
    for (uint32_t symbol = 0; symbol <= max_symbol; ++symbol)
      if (frequencies[symbol] > 0) entries.push_back({symbol, frequencies[symbol]});
  } else {
    std::vector<uint32_t> sorted(symbols.begin(), symbols.end());
    std::sort(sorted.begin(), sorted.end());
    for (const uint32_t symbol : sorted) {
      if (entries.empty() || entries.back().symbol != symbol) entries.push_back({symbol});
      ++entries.back().frequency;
    }
  }
  return entries;
}

// libdraco's estimates decide between the codings. Terms, types and their order are libdraco's, so that sums
// round alike. log2 is the C library's in both; another library may round the last bit differently.
int64_t entropy_bits(const std::vector<SymbolCount>& entries, size_t symbol_count) {
  double bits = 0;
  const auto count = static_cast<double>(symbol_count);
  for (const SymbolCount& entry : entries) {
    const auto frequency = static_cast<double>(entry.frequency);
    bits += frequency * std::log2(frequency / count);
  }
  return static_cast<int64_t>(-bits);
}
int64_t table_bits(int64_t max_symbol, int64_t unique_count) {
  return 8 * unique_count + 8 * (unique_count + (max_symbol - unique_count) / 64);
}

// Scales frequencies to probabilities that add up to 1 << precision.
void normalize(std::vector<SymbolCount>& entries, size_t symbol_count, uint32_t precision) {
  const int64_t total = int64_t{1} << precision;
  const auto total_d = static_cast<double>(total);
  int64_t sum = 0;
  for (SymbolCount& entry : entries) {
    const double part = static_cast<double>(entry.frequency) / static_cast<double>(symbol_count);
    entry.prob = std::max(1u, static_cast<uint32_t>(part * total_d + 0.5));
    sum += entry.prob;
  }
  if (sum != total) {
    std::vector<uint32_t> order(entries.size());  // by probability
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return entries[a].prob < entries[b].prob; });
    if (sum < total) entries[order.back()].prob += static_cast<uint32_t>(total - sum);
    // libdraco never changes the first of its sorted symbols. It also sorts symbols that do not occur.
    const bool all_occur = entries.size() == size_t{entries.back().symbol} + 1;
    // The loop ends: all precisions have more than twice as many places as there are symbols.
    while (sum > total) {
      const double scale = total_d / static_cast<double>(sum);
      for (size_t j = order.size(); j-- > (all_occur ? 1u : 0u) && sum > total;) {
        uint32_t& prob = entries[order[j]].prob;
        if (prob <= 1) break;
        const auto scaled = static_cast<uint32_t>(std::floor(scale * static_cast<double>(prob)));
        const int64_t most = std::min(sum - total, int64_t{prob} - 1);
        const int64_t less = std::min(std::max(int64_t{prob} - scaled, int64_t{1}), most);
        prob -= static_cast<uint32_t>(less);
        sum -= less;
      }
    }
  }
  uint32_t first = 0;
  for (SymbolCount& entry : entries) {
    entry.first = first;
    first += entry.prob;
  }
}

void write_table(const std::vector<SymbolCount>& entries, std::vector<uint8_t>& out) {
  append_varint(uint64_t{entries.back().symbol} + 1, out);
  uint32_t next = 0;
  for (const SymbolCount& entry : entries) {
    while (next < entry.symbol) {  // a byte for up to 64 symbols that do not occur
      const uint32_t run = std::min(64u, entry.symbol - next);
      out.push_back(static_cast<uint8_t>((run - 1) << 2 | 3));
      next += run;
    }
    const uint32_t extra_bytes = entry.prob < 1u << 6 ? 0 : entry.prob < 1u << 14 ? 1 : 2;
    out.push_back(static_cast<uint8_t>(entry.prob << 2 | extra_bytes));
    for (uint32_t i = 0; i < extra_bytes; ++i) out.push_back(static_cast<uint8_t>(entry.prob >> (8 * i + 6)));
    ++next;
  }
}

// Writes the state after the bytes of a block: the top two bits of the last byte say how many bytes it takes.
void write_state(uint32_t state, std::vector<uint8_t>& block) {
  const uint32_t bytes = state < 1u << 6 ? 1 : state < 1u << 14 ? 2 : state < 1u << 22 ? 3 : 4;
  state |= (bytes - 1) << (8 * bytes - 2);
  for (uint32_t i = 0; i < bytes; ++i) block.push_back(static_cast<uint8_t>(state >> 8 * i));
}

uint32_t precision_of(uint32_t symbol_bits) { return std::clamp(3 * symbol_bits / 2, 12u, 20u); }

// Writes the table of the symbols and a block of rANS, which codes the last symbol first. Returns the bytes of
// the table.
size_t write_rans(std::span<const uint32_t> symbols, std::vector<SymbolCount> entries, uint32_t symbol_bits,
                  std::vector<uint8_t>& out) {
  const uint32_t precision = precision_of(symbol_bits);
  normalize(entries, symbols.size(), precision);
  const size_t before = out.size();
  write_table(entries, out);
  const size_t table_bytes = out.size() - before;
  // Division by a product: states are below 2^30, so that the quotient is exact (T. Granlund, P. Montgomery:
  // Division by invariant integers using multiplication, 1994).
  struct Coder {
    uint64_t inverse;  // 2^shift / prob, rounded up
    uint32_t shift, prob, first;
  };
  std::vector<Coder> coders(entries.size());
  std::vector<uint32_t> coder_of(size_t{entries.back().symbol} + 1);
  for (uint32_t i = 0; i < entries.size(); ++i) {
    const SymbolCount& entry = entries[i];
    const auto shift = static_cast<uint32_t>(30 + std::bit_width(entry.prob - 1));
    coders[i] = {((uint64_t{1} << shift) + entry.prob - 1) / entry.prob, shift, entry.prob, entry.first};
    coder_of[entry.symbol] = i;
  }
  const uint32_t base = 4u << precision;
  uint32_t state = base;
  // A state is below 2^(precision + 10) before a symbol, and below prob << 10 after its bytes, at most three.
  // Nothing branches on how many: a processor could not predict it.
  size_t most_bytes = sizeof state;
  for (const SymbolCount& entry : entries)
    most_bytes +=
        size_t{entry.frequency} * ((precision + 8 - static_cast<uint32_t>(std::bit_width(entry.prob))) / 8);
  const std::unique_ptr<uint8_t[]> block(new uint8_t[most_bytes]);
  size_t size = 0;
  for (size_t i = symbols.size(); i-- > 0;) {
    const Coder& coder = coders[coder_of[symbols[i]]];
    const uint64_t most = uint64_t{coder.prob} << 10;
    const uint32_t bytes = (state >= most) + (state >= most << 8) + (state >= most << 16);
    std::memcpy(&block[size], &state, sizeof state);  // little-endian
    size += bytes;
    state >>= 8 * bytes;
    const auto quotient = static_cast<uint32_t>(state * coder.inverse >> coder.shift);
    state = (quotient << precision) + (state - quotient * coder.prob) + coder.first;
  }
  std::vector<uint8_t> last;
  write_state(state - base, last);
  append_varint(size + last.size(), out);
  out.insert(out.end(), &block[0], &block[size]);
  out.insert(out.end(), last.begin(), last.end());
  return table_bytes;
}

constexpr uint32_t kMostRawBits = 18, kTagBits = 5;

// The byte that libdraco stores before the table of the raw coding. The precision of probabilities follows from
// it.
uint32_t symbol_bits_at(uint32_t unique_count, uint32_t max_symbol, int level) {
  if (level == kLevelBeforeLevels) return static_cast<uint32_t>(std::bit_width(std::max(max_symbol, 1u)));
  const int change = level < 4 ? -2 : level < 6 ? -1 : level < 8 ? 0 : level < 10 ? 1 : 2;
  const int bits = static_cast<int>(std::bit_width(unique_count)) + change;
  return static_cast<uint32_t>(std::clamp(bits, 1, static_cast<int>(kMostRawBits)));
}

}  // namespace

void append_block(std::span<const uint8_t> block, std::vector<uint8_t>& out) {
  append_varint(block.size(), out);
  out.insert(out.end(), block.begin(), block.end());
}

void encode_flags(std::span<const uint8_t> flags, std::vector<uint8_t>& out) {
  size_t zeros = 0;
  for (const uint8_t flag : flags) zeros += flag == 0;
  const auto total = static_cast<double>(std::max<size_t>(flags.size(), 1));
  const double part = static_cast<double>(zeros) / total;
  const uint32_t zero = std::clamp(static_cast<uint32_t>(part * 256.0 + 0.5), 1u, 255u), one = 256 - zero;
  constexpr uint32_t kBase = 4096;
  uint32_t state = kBase;
  // Division by a product: states are below 2^20, so that the quotient is exact.
  struct Coder {
    uint32_t prob, first;
    uint64_t inverse;  // 2^32 / prob, rounded up
  };
  const auto coder = [](uint32_t prob, uint32_t first) {
    return Coder{prob, first, ((uint64_t{1} << 32) + prob - 1) / prob};
  };
  const Coder coders[] = {coder(zero, one), coder(one, 0)};
  std::vector<uint8_t> block(flags.size() + sizeof state);  // a flag takes at most a byte
  size_t size = 0;
  for (size_t i = flags.size(); i-- > 0;) {
    const Coder& of = coders[flags[i] != 0 ? 1 : 0];
    block[size] = static_cast<uint8_t>(state);
    const bool is_full = state >= of.prob << 12;
    size += is_full ? 1 : 0;
    state >>= is_full ? 8 : 0;
    const auto quotient = static_cast<uint32_t>(state * of.inverse >> 32);
    state = (quotient << 8) + (state - quotient * of.prob) + of.first;
  }
  block.resize(size);
  write_state(state - kBase, block);
  out.push_back(static_cast<uint8_t>(zero));
  append_block(block, out);
}

CountedSymbols::CountedSymbols(std::span<const uint32_t> symbols, uint32_t components)
    : symbols_(symbols), components_(components), tags_(symbols.size() / components) {
  int64_t value_bits = 0;
  for (size_t group = 0; group < tags_.size(); ++group) {
    uint32_t largest = 0;
    for (const uint32_t symbol : symbols.subspan(group * components, components))
      largest = std::max(largest, symbol);
    tags_[group] = static_cast<uint32_t>(std::bit_width(std::max(largest, 1u)));
    max_symbol_ = std::max(max_symbol_, largest);
    value_bits += int64_t{tags_[group]} * components;
  }
  value_bytes_ = static_cast<size_t>((value_bits + 7) / 8);
  constexpr uint32_t kMaxTag = 32;
  std::vector<SymbolCount> tag_entries = count_symbols(tags_, kMaxTag);
  is_tagged_ = max_symbol_ >> kMostRawBits != 0;
  if (!is_tagged_) {
    const auto tag_count = static_cast<int64_t>(tag_entries.size());
    const int64_t tagged_bits =
        entropy_bits(tag_entries, tags_.size()) + table_bits(tag_count, tag_count) + value_bits;
    entries_ = count_symbols(symbols, max_symbol_);
    is_tagged_ = entries_.size() >> kMostRawBits != 0 ||
                 tagged_bits < entropy_bits(entries_, symbols.size()) +
                                   table_bits(max_symbol_, static_cast<int64_t>(entries_.size()));
  }
  if (is_tagged_) entries_ = std::move(tag_entries);
}

uint32_t CountedSymbols::symbol_bits(int level) const {
  return is_tagged_ ? kTagBits : symbol_bits_at(static_cast<uint32_t>(entries_.size()), max_symbol_, level);
}

size_t CountedSymbols::estimate(int level) const {
  if (symbols_.empty()) return 0;
  std::vector<SymbolCount> entries = entries_;
  const uint32_t precision = precision_of(symbol_bits(level));
  normalize(entries, is_tagged_ ? tags_.size() : symbols_.size(), precision);
  std::vector<uint8_t> table;
  write_table(entries, table);
  double bits = 0;
  for (const SymbolCount& entry : entries)
    bits += static_cast<double>(entry.frequency) * (precision - std::log2(static_cast<double>(entry.prob)));
  return table.size() + static_cast<size_t>(bits / 8) + (is_tagged_ ? value_bytes_ : 0);
}

size_t CountedSymbols::write(int level, std::vector<uint8_t>& out) const {
  if (symbols_.empty()) return 0;
  out.push_back(is_tagged_ ? 0 : 1);
  if (!is_tagged_) out.push_back(static_cast<uint8_t>(symbol_bits(level)));
  const size_t table_bytes =
      write_rans(is_tagged_ ? std::span<const uint32_t>(tags_) : symbols_, entries_, symbol_bits(level), out);
  if (!is_tagged_) return table_bytes;
  BitStringWriter values;
  for (size_t group = 0; group < tags_.size(); ++group)
    for (const uint32_t symbol : symbols_.subspan(group * components_, components_))
      values.bits(symbol, tags_[group]);
  const std::vector<uint8_t> bytes = values.take();
  out.insert(out.end(), bytes.begin(), bytes.end());
  return table_bytes;
}

size_t encode_symbols(std::span<const uint32_t> symbols, uint32_t components, int level,
                      std::vector<uint8_t>& out) {
  return CountedSymbols(symbols, components).write(level, out);
}

uint32_t possible_symbol_levels(std::span<const uint32_t> symbols, uint32_t symbol_bits) {
  uint32_t max_symbol = 0, levels = 0;
  for (const uint32_t symbol : symbols) max_symbol = std::max(max_symbol, symbol);
  const auto unique_count = static_cast<uint32_t>(count_symbols(symbols, max_symbol).size());
  for (int level = 0; level <= kLevelBeforeLevels; ++level)
    if (symbol_bits_at(unique_count, max_symbol, level) == symbol_bits) levels |= 1u << level;
  return levels;
}

}  // namespace psplit
