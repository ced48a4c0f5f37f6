#include "encoder/condensing/frequencies.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "src/core/condensed/models.h"

namespace psplit {
namespace {

std::vector<std::vector<uint64_t>> counts_of_every_shape() {
  std::vector<std::vector<uint64_t>> all = {{7}, {0, 1}, {1, 1000000000}, {1, 1, 1}, {0, 5, 0, 3, 0}};
  std::mt19937_64 random(1);
  for (const size_t size : {5u, 30u, 116u, 4096u})
    for (const int shift : {64 - 2, 64 - 10, 64 - 40}) {
      std::vector<uint64_t> counts(size);
      for (uint64_t& count : counts) count = (random() >> shift) >> random() % 40;
      counts[0] = 1;
      all.push_back(std::move(counts));
    }
  return all;
}

TEST(Frequencies, SumTo4096AndEverySymbolThatOccursHasOne) {
  for (const std::vector<uint64_t>& counts : counts_of_every_shape()) {
    const std::vector<uint16_t> frequencies = fitting_frequencies(counts);
    ASSERT_EQ(frequencies.size(), counts.size());
    EXPECT_EQ(std::accumulate(frequencies.begin(), frequencies.end(), 0u), core::kSlots);
    for (size_t i = 0; i < counts.size(); ++i) EXPECT_EQ(frequencies[i] > 0, counts[i] > 0);
  }
  EXPECT_EQ(fitting_frequencies(std::vector<uint64_t>(5)), std::vector<uint16_t>(5));
}

// To take one from a symbol and give it to another saves no more than rounding explains.
TEST(Frequencies, AreBest) {
  for (const std::vector<uint64_t>& counts : counts_of_every_shape()) {
    if (counts.size() > 200) continue;
    std::vector<uint16_t> frequencies = fitting_frequencies(counts);
    const double bits = coded_bits(counts, frequencies);
    for (size_t from = 0; from < counts.size(); ++from)
      for (size_t to = 0; to < counts.size(); ++to) {
        if (from == to || counts[to] == 0 || frequencies[from] < 2) continue;
        --frequencies[from], ++frequencies[to];
        EXPECT_GE(coded_bits(counts, frequencies), bits * (1 - 1e-3));
        ++frequencies[from], --frequencies[to];
      }
  }
}

TEST(Frequencies, BitsAreThoseOfAnIdealCoder) {
  const std::vector<uint64_t> counts = {8, 4, 4};
  const std::vector<uint16_t> frequencies = fitting_frequencies(counts);
  EXPECT_EQ(frequencies, (std::vector<uint16_t>{2048, 1024, 1024}));
  EXPECT_DOUBLE_EQ(coded_bits(counts, frequencies), 8 * 1 + 8 * 2);
  EXPECT_NEAR(coded_bits(std::vector<uint64_t>{1, 1}, std::vector<uint16_t>{3, 4093}), 10.416, 1e-3);
}

TEST(Frequencies, ProbabilitiesAreNeverCertain) {
  EXPECT_EQ(fitting_probability(0, 0), 1u);
  EXPECT_EQ(fitting_probability(1000, 0), 1u);
  EXPECT_EQ(fitting_probability(0, 1000), 4095u);
  EXPECT_EQ(fitting_probability(1, 3), 3072u);
  EXPECT_EQ(fitting_probability(~uint64_t{0} >> 1, ~uint64_t{0} >> 1), 2048u);
}

}  // namespace
}  // namespace psplit
