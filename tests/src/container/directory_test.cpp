#include "src/container/directory.h"

#include <random>

#include "src/container/bit_string.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"

namespace psplit {
namespace {

// Rows as in real containers: about as many faces each, half as many points, some references.
std::vector<StreamEntry> likely_rows(std::mt19937& random, size_t count, uint32_t skeleton_count) {
  const auto about = [&](uint32_t value) { return value - value / 20 + random() % (value / 10 + 1); };
  std::vector<StreamEntry> rows;
  for (size_t i = 0; i < count; ++i) {
    StreamEntry row{.face_count = static_cast<uint32_t>(about(440))};
    row.point_count = static_cast<uint32_t>(about(row.face_count / 2 + 30));
    row.reference_count = i == 0 ? 0 : static_cast<uint32_t>(about(40));
    if (row.reference_count > 0) row.stitch_bytes = static_cast<uint32_t>(about(row.reference_count / 4));
    row.stream_bytes = static_cast<uint32_t>(about(row.point_count * 3));
    row.is_condensed = random() % 8 != 0;
    if (row.is_condensed) row.skeleton = static_cast<uint8_t>(random() % skeleton_count);
    rows.push_back(row);
  }
  return rows;
}

// Numbers of any size up to `most_bits` bits.
std::vector<StreamEntry> wild_rows(std::mt19937& random, size_t count, int most_bits) {
  const auto wild = [&] {
    const auto bits = random() % static_cast<unsigned>(most_bits + 1);
    return static_cast<uint32_t>(random() & ((uint64_t{1} << bits) - 1));
  };
  std::vector<StreamEntry> rows;
  for (size_t i = 0; i < count; ++i) {
    StreamEntry row{wild(), wild(), wild(), wild(), wild(), random() % 2 == 0, 0};
    if (row.reference_count == 0) row.stitch_bytes = 0;
    rows.push_back(row);
  }
  return rows;
}

Expected<std::vector<StreamEntry>> read_rows(const std::vector<uint8_t>& bytes, size_t count,
                                             bool has_residue = false) {
  std::vector<StreamEntry> rows(count);
  const Expected<uint32_t> skeletons = read_directory(bytes, has_residue, rows);
  if (!skeletons) return skeletons.status();
  return rows;
}

TEST(Directory, GivesBackWhatWasWritten) {
  std::mt19937 random(5);
  for (const uint32_t skeletons : {0u, 1u, 2u, 255u})
    for (const size_t count : {1u, 2u, 3u, 500u})
      for (const bool has_residue : {false, true}) {
        std::vector<StreamEntry> rows = likely_rows(random, count, std::max(skeletons, 1u));
        StreamEntry& last = rows.at(count - 1);
        if (has_residue) last.is_condensed = false, last.skeleton = 0;
        for (StreamEntry& row : rows)
          if (skeletons == 0) row.is_condensed = false;
        const auto read = must(read_rows(write_directory(rows, has_residue), count, has_residue));
        EXPECT_EQ(read, rows);
      }
}

TEST(Directory, CountsTheSkeletonsOfCondensedRows) {
  const auto count = [](std::vector<StreamEntry> rows) {
    return *read_directory(write_directory(rows, false), false, rows);
  };
  EXPECT_EQ(count({{9, 2, 4, 0, 0}}), 0u);
  EXPECT_EQ(count({{9, 2, 4, 0, 0, true, 0}, {9, 2, 4, 0, 0}}), 1u);
  EXPECT_EQ(count({{9, 2, 4, 0, 0, true, 6}, {9, 2, 4, 0, 0, true, 1}}), 7u);
}

TEST(Directory, TakesFewBytesForSimilarRows) {
  std::mt19937 random(6);
  EXPECT_LT(write_directory(likely_rows(random, 1000, 1), false).size(), size_t{5} * 1000);
  // Rows that are all condensed, or all stored, do not say so one by one.
  std::vector<StreamEntry> stored(1000, {9, 2, 4, 0, 0}), condensed(1000, {9, 2, 4, 0, 0, true, 0});
  EXPECT_EQ(write_directory(stored, false).size(), write_directory(condensed, false).size());
  stored[500].is_condensed = true;
  EXPECT_GT(write_directory(stored, false).size(), write_directory(condensed, false).size() + 100);
}

// The distance from the expected number is taken modulo 2^32, so every number can be written.
TEST(Directory, GivesBackAnyNumbers) {
  std::mt19937 random(7);
  for (int round = 0; round < 4000; ++round) {
    const std::vector<StreamEntry> rows = wild_rows(random, 1 + random() % 8, 1 + round % 32);
    const auto read = read_rows(write_directory(rows, false), rows.size());
    ASSERT_TRUE(read) << round;
    EXPECT_EQ(*read, rows) << round;
  }
  // Large steps up and down, and the largest ratio with the largest scale.
  const std::vector<StreamEntry> rows = {{0xffffffffu, 0xffffffffu, 1, 0, 0},
                                         {0, 0, 0xffffffffu, 0xffffffffu, 0xffffffffu},
                                         {0x80000000u, 0x80000000u, 0xffffffffu, 1, 0xffffffffu},
                                         {0xffffffffu, 0x7fffffffu, 0, 0xffffffffu, 0}};
  const auto read = must(read_rows(write_directory(rows, false), rows.size()));
  EXPECT_EQ(read, rows);
}

TEST(Directory, RefusesEveryTruncationAndEveryExtension) {
  std::mt19937 random(8);
  std::vector<uint8_t> bytes = write_directory(likely_rows(random, 20, 3), false);
  for_each_truncation(bytes, [](const std::vector<uint8_t>& part) {
    const Status status = read_rows(part, 20).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidInput) << part.size();
    EXPECT_EQ(status.message(), "directory: a row that ends early, or names a skeleton that does not exist");
    EXPECT_GE(status.place().patch, 0);
  });
  bytes.push_back(0);
  EXPECT_EQ(read_rows(bytes, 20).status().message(), "directory: it goes on after its last row");
  EXPECT_FALSE(read_rows(bytes, 19).ok());
}

TEST(Directory, RefusesUnusedBitsThatAreNotZero) {
  // 1 + 7 + 4 + 4 + 7 bits, and one that is not used.
  std::vector<uint8_t> bytes = write_directory(std::vector<StreamEntry>{{1, 2, 1, 0, 0}}, false);
  ASSERT_EQ(bytes.size(), 3u);
  ASSERT_TRUE(read_rows(bytes, 1).ok());
  bytes.back() |= 0x80;
  EXPECT_FALSE(read_rows(bytes, 1).ok());
}

TEST(Directory, RefusesSkeletonsThatDoNotExist) {
  BitStringWriter writer;
  core::NumberKind count(0), skeleton(0);
  writer.number(count, 256);
  EXPECT_EQ(read_rows(writer.take(), 1).status().message(), "directory: more than 255 skeletons");
  count = core::NumberKind(0);
  writer.number(count, 3);
  writer.bits(0, 1);  // all patches are condensed
  writer.number(skeleton, 3);
  writer.bits(0, 32);
  EXPECT_EQ(read_rows(writer.take(), 1).status().place().patch, 0);
}

// Mutants are refused, or are other rows that can be written again.
TEST(Directory, MutantsAreErrorsOrOtherRows) {
  std::mt19937 random(9);
  const std::vector<StreamEntry> rows = likely_rows(random, 6, 2);
  const std::vector<uint8_t> bytes = write_directory(rows, false);
  size_t refused = 0, read_count = 0;
  for (int round = 0; round < 20000; ++round) {
    std::vector<uint8_t> mutant = bytes;
    for (uint64_t n = 1 + random() % 3; n > 0; --n)
      mutant[random() % mutant.size()] ^= static_cast<uint8_t>(1u << random() % 8);
    const auto read = read_rows(mutant, rows.size());
    if (!read) {
      ++refused;
      continue;
    }
    ++read_count;
    EXPECT_EQ(*read_rows(write_directory(*read, false), rows.size()), *read);
  }
  EXPECT_GT(refused, 1000u);
  EXPECT_GT(read_count, 1000u);
}

TEST(BitString, ReadsTheNumbersThatItWrites) {
  std::mt19937 random(10);
  for (int round = 0; round < 200; ++round) {
    std::vector<uint32_t> numbers;
    for (int i = 0; i < 50; ++i) numbers.push_back(static_cast<uint32_t>(random() >> random() % 33));
    numbers.push_back(0xffffffffu);
    BitStringWriter writer;
    core::NumberKind written(static_cast<uint32_t>(round % 10)), read = written, signs(2), signs_read(2);
    for (const uint32_t number : numbers) {
      writer.number(written, number);
      writer.signed_number(signs, int64_t{number} - 0x80000000);
      writer.bits(number, 7);
    }
    const std::vector<uint8_t> bytes = writer.take();
    BitStringReader reader(bytes);
    for (const uint32_t number : numbers) {
      EXPECT_EQ(reader.number(read), number);
      EXPECT_EQ(reader.signed_number(signs_read), int64_t{number} - 0x80000000);
      EXPECT_EQ(reader.bits(7), number & 0x7f);
    }
    EXPECT_FALSE(reader.broken());
    EXPECT_TRUE(reader.ends_here());
    (void)reader.bits(1);
    EXPECT_TRUE(reader.broken());
  }
}

TEST(BitString, RefusesCodesThatAreTooLong) {
  const std::vector<uint8_t> zeros(20);
  BitStringReader reader(zeros);
  core::NumberKind kind(0);
  (void)reader.number(kind);
  EXPECT_TRUE(reader.broken());
}

}  // namespace
}  // namespace psplit
