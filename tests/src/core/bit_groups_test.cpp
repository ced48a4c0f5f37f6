// Lanes that each read a group of bits get the same values as one reader of all bits.
#include "src/core/bit_groups.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/emulated_warp.h"
#include "tests/support/mutants.h"

namespace psplit::core {
namespace {

struct Taken {
  Fault fault = Fault::kNone;
  std::vector<uint32_t> values;
  size_t bytes_left = 0;

  bool operator==(const Taken&) const = default;
};

Taken one_after_the_other(const std::vector<uint8_t>& bytes, const std::vector<uint32_t>& tags,
                          uint32_t components) {
  Taken out;
  ByteReader reader(bytes.data(), bytes.size());
  BitReader bits(bytes.data(), bytes.size());
  for (const uint32_t tag : tags) {
    if (tag > 32) return {Fault::kEntropy, {}, bytes.size()};
    for (uint32_t k = 0; k < components; ++k) out.values.push_back(bits.read(static_cast<int>(tag)));
  }
  out.fault = reader.skip(bits.bytes_taken()) ? Fault::kNone : Fault::kTruncated;
  out.bytes_left = reader.remaining();
  return out;
}

// Every lane must return the same. The tags are the end of the values, as in SymbolSequence.
template <typename Run>
Taken together(Run run, const std::vector<uint8_t>& bytes, const std::vector<uint32_t>& tags,
               uint32_t components) {
  std::vector<Taken> said(32);
  std::vector<uint32_t> values(tags.size() * components);
  std::copy(tags.begin(), tags.end(), values.end() - static_cast<ptrdiff_t>(tags.size()));
  uint32_t size = 0;
  run([&](auto lanes) {
    if (lanes.rank() == 0) size = lanes.size();
    Taken& mine = said[lanes.rank()];
    ByteReader reader(bytes.data(), bytes.size());
    const View<const uint32_t> last(values.data() + values.size() - tags.size(), tags.size());
    mine.fault = read_tagged(lanes, reader, last, components, View<uint32_t>(values.data(), values.size()));
    if (mine.fault != Fault::kEntropy) mine.values = values;
    mine.bytes_left = reader.remaining();
  });
  for (uint32_t r = 1; r < size; ++r) EXPECT_EQ(said[r], said[0]);
  return said[0];
}

void expect_same(const std::vector<uint8_t>& bytes, const std::vector<uint32_t>& tags, uint32_t components) {
  const Taken expected = one_after_the_other(bytes, tags, components);
  ASSERT_EQ(together([](auto body) { body(SerialLanes()); }, bytes, tags, components), expected);
  for (const LaneOrder& order : kLaneOrders) {
    const auto run = [&](auto body) { run_warp([&](EmulatedLanes lanes) { body(lanes); }, order); };
    ASSERT_EQ(together(run, bytes, tags, components), expected);
  }
}

struct Groups {
  std::vector<uint8_t> bytes;  // the tags say how many
  std::vector<uint32_t> tags;
};

Groups random_groups(std::mt19937& random, uint32_t group_count, uint32_t components, uint32_t most_bits) {
  Groups out;
  size_t bits = 0;
  for (uint32_t g = 0; g < group_count; ++g) {
    out.tags.push_back(static_cast<uint32_t>(random() % (most_bits + 1)));
    bits += size_t{out.tags.back()} * components;
  }
  for (size_t i = 0; i < (bits + 7) / 8; ++i) out.bytes.push_back(static_cast<uint8_t>(random()));
  return out;
}

constexpr uint32_t kComponents[] = {1, 2, 3, 4, 7, 255};

TEST(ReadTagged, TakesWhatASerialReaderTakes) {
  std::mt19937 random(1);
  for (const uint32_t components : kComponents)
    for (const uint32_t group_count : {0u, 1u, 2u, 31u, 32u, 33u, 100u})
      for (const uint32_t most_bits : {0u, 1u, 13u, 32u}) {
        Groups groups = random_groups(random, group_count, components, most_bits);
        expect_same(groups.bytes, groups.tags, components);
        groups.bytes.resize(groups.bytes.size() + 20, 0xff);  // other data may follow
        expect_same(groups.bytes, groups.tags, components);
      }
}

TEST(ReadTagged, ReadsZerosPastTheEnd) {
  std::mt19937 random(2);
  for (const uint32_t components : {1u, 3u}) {
    const Groups groups = random_groups(random, 40, components, 32);
    for_each_truncation(
        groups.bytes, [&](const std::vector<uint8_t>& bytes) { expect_same(bytes, groups.tags, components); });
  }
}

TEST(ReadTagged, RefusesMoreThan32Bits) {
  std::mt19937 random(3);
  for (const uint32_t bits : {33u, 57u, 64u, 0x80000000u, 0xffffffffu})
    for (const size_t place : {0u, 5u, 31u, 32u, 69u}) {
      Groups groups = random_groups(random, 70, 3, 32);
      groups.tags[place] = bits;
      expect_same(groups.bytes, groups.tags, 3);
      expect_same({}, groups.tags, 3);
    }
}

}  // namespace
}  // namespace psplit::core
