#include "src/container/condensed_directory.h"

#include <gtest/gtest.h>

#include <random>

#include "src/container/bit_string.h"

namespace psplit {
namespace {

// Rows like those of real containers: about as many faces each, half as many points, some references.
std::vector<StreamEntry> likely_rows(std::mt19937& random, size_t count, uint32_t skeleton_count) {
  const auto about = [&](uint32_t value) { return value - value / 20 + random() % (value / 10 + 1); };
  std::vector<StreamEntry> rows;
  for (size_t i = 0; i < count; ++i) {
    StreamEntry row;
    row.face_count = static_cast<uint32_t>(about(440));
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

TEST(CondensedDirectory, GivesBackWhatWasWritten) {
  std::mt19937 random(5);
  for (const uint32_t skeletons : {1u, 2u, 255u})
    for (const size_t count : {1u, 2u, 3u, 500u}) {
      const std::vector<StreamEntry> rows = likely_rows(random, count, skeletons);
      const auto bytes = write_condensed_directory(rows, skeletons);
      ASSERT_TRUE(bytes.has_value());
      std::vector<StreamEntry> read(rows.size());
      const Status status = read_condensed_directory(*bytes, skeletons, read);
      EXPECT_TRUE(status.ok()) << status.to_string();
      EXPECT_EQ(read, rows);
    }
}

TEST(CondensedDirectory, TakesFewBytesForSimilarRows) {
  std::mt19937 random(6);
  const auto bytes = write_condensed_directory(likely_rows(random, 1000, 1), 1);
  // A directory of version 2 takes 7 bytes for such a row.
  EXPECT_LT(bytes->size(), size_t{5} * 1000);
}

TEST(CondensedDirectory, GivesBackAnyNumbersThatItWrites) {
  std::mt19937 random(7);
  size_t written = 0;
  for (int round = 0; round < 4000; ++round) {
    const std::vector<StreamEntry> rows = wild_rows(random, 1 + random() % 8, 1 + round % 32);
    const auto bytes = write_condensed_directory(rows, 1);
    if (!bytes) continue;
    ++written;
    std::vector<StreamEntry> read(rows.size());
    ASSERT_TRUE(read_condensed_directory(*bytes, 1, read).ok()) << round;
    EXPECT_EQ(read, rows) << round;
  }
  EXPECT_GT(written, 3000u);
}

// A number may be 2^31 and more from what is expected: version 2 writes it.
TEST(CondensedDirectory, DoesNotWriteWhatItsCodesCannotHold) {
  EXPECT_FALSE(write_condensed_directory(std::vector<StreamEntry>{{1, 0x80000000u, 3, 0, 0}}, 0).has_value());
  EXPECT_TRUE(write_condensed_directory(std::vector<StreamEntry>{{1, 0x7fffffffu, 3, 0, 0}}, 0).has_value());
  // The ratio of bytes to points times the points of the next row has more than 63 bits.
  const std::vector<StreamEntry> product = {{0x7fffffffu, 1, 1, 0, 0}, {9, 1, 0x7ffffff0u, 0, 0}};
  EXPECT_FALSE(write_condensed_directory(product, 0).has_value());
}

TEST(CondensedDirectory, RefusesEveryTruncationAndEveryExtension) {
  std::mt19937 random(8);
  const std::vector<StreamEntry> rows = likely_rows(random, 20, 3);
  std::vector<uint8_t> bytes = *write_condensed_directory(rows, 3);
  std::vector<StreamEntry> read(rows.size());
  for (size_t length = 0; length < bytes.size(); ++length) {
    // An exactly sized buffer, so that a sanitizer sees any read past it.
    const std::vector<uint8_t> part(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length));
    const Status status = read_condensed_directory(part, 3, read);
    EXPECT_EQ(status.code(), StatusCode::kInvalidInput) << length;
    EXPECT_EQ(status.message(), "directory: a row that ends early, or with an impossible number");
    EXPECT_GE(status.place().patch, 0);
  }
  bytes.push_back(0);
  EXPECT_EQ(read_condensed_directory(bytes, 3, read).message(), "directory: it goes on after its last row");
  EXPECT_FALSE(read_condensed_directory(bytes, 3, std::span(read).first(19)).ok());
}

TEST(CondensedDirectory, RefusesUnusedBitsThatAreNotZero) {
  // 1 + 13 + 5 + 4 + 7 bits of a row of numbers as they are expected, and unused bits.
  const std::vector<StreamEntry> rows = {{1, 2, 1, 0, 0}};
  std::vector<uint8_t> bytes = *write_condensed_directory(rows, 0);
  std::vector<StreamEntry> read(1);
  ASSERT_TRUE(read_condensed_directory(bytes, 0, read).ok());
  bytes.back() |= 0x80;
  EXPECT_FALSE(read_condensed_directory(bytes, 0, read).ok());
}

TEST(CondensedDirectory, RefusesSkeletonsThatDoNotExist) {
  std::vector<StreamEntry> rows = {{9, 2, 4, 0, 0, true, 2}};
  const std::vector<uint8_t> bytes = *write_condensed_directory(rows, 3);
  EXPECT_TRUE(read_condensed_directory(bytes, 3, rows).ok());
  EXPECT_EQ(read_condensed_directory(bytes, 2, rows).place().patch, 0);
  // A condensed stream without a head.
  EXPECT_FALSE(read_condensed_directory(bytes, 0, rows).ok());
  EXPECT_FALSE(write_condensed_directory(rows, 2).has_value());
}

// Mutants are refused, or are other rows that can be written again.
TEST(CondensedDirectory, MutantsAreErrorsOrOtherRows) {
  std::mt19937 random(9);
  const std::vector<StreamEntry> rows = likely_rows(random, 6, 2);
  const std::vector<uint8_t> bytes = *write_condensed_directory(rows, 2);
  size_t refused = 0, read_count = 0;
  for (int round = 0; round < 20000; ++round) {
    std::vector<uint8_t> mutant = bytes;
    for (uint64_t n = 1 + random() % 3; n > 0; --n)
      mutant[random() % mutant.size()] ^= static_cast<uint8_t>(1u << random() % 8);
    std::vector<StreamEntry> read(rows.size());
    if (!read_condensed_directory(mutant, 2, read).ok()) {
      ++refused;
      continue;
    }
    ++read_count;
    EXPECT_EQ(write_condensed_directory(read, 2), mutant);
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
