#include "encoder/condensing/table_sets.h"

#include <algorithm>
#include <numeric>

namespace psplit {
namespace {

// The number of sets is doubled as long as this saves the share kWorthTwice of all bits. More sets decode
// slower, because the tables of a set take 15 KB, and patches that follow each other seldom use the same set: 8
// sets take 1 to 4 % more time than one, 4 sets at most 1 % (Dragon, patches of 440 faces, positions and all
// attributes). The last doubling saves 0.1 to 0.4 % of the bits.
constexpr double kWorthTwice = 0.0015;  // of all bits

constexpr size_t kTables = std::tuple_size_v<decltype(AttributeCounts::tokens)>;
// The bits of each token with the tables of a set, in 65536ths: sums are exact.
using TokenBits = std::array<std::array<uint32_t, core::kTokenCount>, kTables>;

// A token that the set does not have yet would get a slot in its table.
TokenBits bits_of_tokens(const AttributeCounts& set) {
  TokenBits bits;
  for (size_t t = 0; t < kTables; ++t) {
    const std::vector<uint16_t> table = fitting_frequencies(set.tokens[t]);
    for (uint32_t token = 0; token < core::kTokenCount; ++token) {
      const std::array frequency{std::max<uint16_t>(table[token], 1)};
      bits[t][token] = static_cast<uint32_t>(65536 * coded_bits(std::array{uint64_t{1}}, frequency));
    }
  }
  return bits;
}

uint64_t bits_of_patch(const PatchTokens& patch, const TokenBits& bits) {
  uint64_t sum = 0;
  for (const auto [table, token, count] : patch) sum += uint64_t{count} * bits[table][token];
  return sum;
}

// The mean of all tokens orders patches by the size of their corrections.
double mean_token(const PatchTokens& patch) {
  uint64_t sum = 0, tokens = 0;
  for (const auto [table, token, count] : patch) sum += uint64_t{count} * token, tokens += count;
  return static_cast<double>(sum) / static_cast<double>(std::max<uint64_t>(tokens, 1));
}

std::vector<AttributeCounts> sums(std::span<const PatchTokens> patches, std::span<const uint8_t> set,
                                  uint32_t set_count) {
  std::vector<AttributeCounts> counts(set_count);
  for (size_t i = 0; i < patches.size(); ++i)
    for (const auto [table, token, count] : patches[i]) counts[set[i]].tokens[table][token] += count;
  return counts;
}

double all_bits(const TableSets& sets) {
  double bits = 0;
  BitStringWriter tables;
  core::NumberKind used = used_kind();
  for (const AttributeCounts& counts : sets.counts)
    for (const TokenCounts& tokens : counts.tokens) {
      const std::vector<uint16_t> table = fitting_frequencies(tokens);
      bits += coded_bits(tokens, table);
      write_token_table(table, used, tables);
    }
  return bits + static_cast<double>(tables.bit_count() + set_bits(sets.counts.size()) * sets.set.size());
}

// Moves each patch to the set whose tables fit it best, round after round (k-means).
void improve(std::span<const PatchTokens> patches, uint32_t count, const ThreadPool& pool,
             std::span<uint8_t> set) {
  constexpr int kMostRounds = 6;
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<TokenBits> bits;
    for (const AttributeCounts& counts : sums(patches, set, count)) bits.push_back(bits_of_tokens(counts));
    constexpr size_t kGrain = 64;
    pool.for_ranges(patches.size(), kGrain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i)
        set[i] = static_cast<uint8_t>(
            std::ranges::min_element(
                bits, {}, [&](const TokenBits& of_set) { return bits_of_patch(patches[i], of_set); }) -
            bits.begin());
    });
  }
}

}  // namespace

PatchTokens patch_tokens(const AttributeCounts& counts) {
  PatchTokens result;
  for (uint16_t table = 0; table < kTables; ++table)
    for (uint16_t token = 0; token < core::kTokenCount; ++token)
      if (const uint64_t count = counts.tokens[table][token]; count > 0)
        result.push_back({table, token, static_cast<uint32_t>(count)});
  return result;
}

TableSets choose_table_sets(std::span<const PatchTokens> patches, uint32_t most, bool smallest,
                            const ThreadPool& pool) {
  std::vector<size_t> by_mean(patches.size());
  std::iota(by_mean.begin(), by_mean.end(), size_t{0});
  std::ranges::stable_sort(by_mean, {}, [&](size_t i) { return mean_token(patches[i]); });
  TableSets best;
  double best_bits = 0;
  for (uint32_t count = 1; count == 1 || count <= std::min<size_t>(patches.size(), most); count *= 2) {
    TableSets sets;
    sets.set.resize(patches.size());
    for (size_t i = 0; i < patches.size(); ++i)
      sets.set[by_mean[i]] = static_cast<uint8_t>(i * count / patches.size());
    if (count > 1) improve(patches, count, pool, sets.set);
    sets.counts = sums(patches, sets.set, count);
    const double bits = all_bits(sets);
    if (count > 1 && bits >= best_bits * (smallest ? 1 : 1 - kWorthTwice)) break;
    best_bits = bits;
    best = std::move(sets);
  }
  return best;
}

}  // namespace psplit
