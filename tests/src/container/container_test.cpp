#include "src/container/container.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

struct Parts {
  std::vector<StreamEntry> entries;
  std::vector<std::vector<uint8_t>> stitch, streams;
};

Parts three_streams() {
  Parts parts;
  parts.entries = {{5, 100, 60, 0, 0}, {300, 101, 61, 7, 4}, {2, 3, 9, 9, 2}};
  for (const StreamEntry& entry : parts.entries) {
    parts.stitch.emplace_back(entry.stitch_bytes, uint8_t{0x11});
    parts.streams.emplace_back(entry.stream_bytes, static_cast<uint8_t>(entry.stream_bytes));
  }
  return parts;
}

std::vector<uint8_t> written(const Parts& parts, bool has_residue) {
  return write_container(parts.entries, has_residue, parts.stitch, parts.streams);
}

TEST(Container, GivesBackWhatWasWritten) {
  const Parts parts = three_streams();
  const std::vector<uint8_t> bytes = written(parts, true);
  const Expected<Container> container = parse_container(bytes);
  ASSERT_TRUE(container.ok()) << container.status().to_string();
  EXPECT_EQ(container->entries, parts.entries);
  EXPECT_EQ(container->patch_count(), 2u);
  EXPECT_EQ(container->point_count(), 60u + 54u + 0u);
  EXPECT_EQ(container->face_count(), 204u);
  EXPECT_EQ(container->reference_count(), 16u);
  EXPECT_EQ(container->header_bytes + container->stitch_bytes() + container->stream_bytes(), bytes.size());
  for (size_t i = 0; i < parts.entries.size(); ++i) {
    EXPECT_TRUE(std::equal(container->streams[i].begin(), container->streams[i].end(), parts.streams[i].begin(),
                           parts.streams[i].end()));
    EXPECT_TRUE(std::equal(container->stitch[i].begin(), container->stitch[i].end(), parts.stitch[i].begin(),
                           parts.stitch[i].end()));
  }
}

TEST(Container, OneStreamCostsFiftyTwoBytes) {
  const std::vector<StreamEntry> entries = {{1000, 12, 8, 0, 0}};
  const std::vector<std::vector<uint8_t>> stitch = {{}}, streams = {std::vector<uint8_t>(1000)};
  EXPECT_EQ(write_container(entries, false, stitch, streams).size(), 1052u);
}

TEST(Container, RefusesEveryTruncationAndEveryExtension) {
  std::vector<uint8_t> bytes = written(three_streams(), true);
  for (size_t length = 0; length < bytes.size(); ++length) {
    // An exactly sized buffer, so that a sanitizer sees any read past it.
    const std::vector<uint8_t> part(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length));
    EXPECT_FALSE(parse_container(part).ok()) << length;
  }
  bytes.push_back(0);
  EXPECT_FALSE(parse_container(bytes).ok());
}

TEST(Container, EveryChangedHeaderByteIsAnErrorOrAnotherDirectory) {
  const std::vector<uint8_t> bytes = written(three_streams(), true);
  const Container original = *parse_container(bytes);
  for (size_t at = 0; at < original.header_bytes; ++at)
    for (int value = 0; value < 256; ++value) {
      std::vector<uint8_t> mutant = bytes;
      mutant[at] = static_cast<uint8_t>(value);
      const Expected<Container> container = parse_container(mutant);
      if (!container.ok()) continue;
      uint64_t end = container->header_bytes + container->stitch_bytes() + container->stream_bytes();
      EXPECT_EQ(end, mutant.size());
      EXPECT_EQ(container->streams.size(), container->entries.size());
    }
}

TEST(Container, NamesThePatchOfABadEntry) {
  Parts parts = three_streams();
  parts.entries[1].reference_count = 62;
  const Expected<Container> container = parse_container(written(parts, true));
  ASSERT_FALSE(container.ok());
  EXPECT_EQ(container.status().place().patch, 1);
  EXPECT_EQ(container.status().code(), StatusCode::kInvalidInput);
}

TEST(Container, RefusesPaddingThatIsNotZero) {
  std::vector<uint8_t> bytes = written(three_streams(), true);
  // Three streams of 5, 300 and 2 bytes: the first column has three values of two bytes, and two bytes of
  // padding.
  ASSERT_EQ(bytes[12 + 4], 2);
  for (const size_t at : {size_t{52 + 6}, size_t{52 + 7}}) {
    std::vector<uint8_t> mutant = bytes;
    mutant[at] = 1;
    EXPECT_FALSE(parse_container(mutant).ok()) << at;
  }
}

TEST(Container, RefusesAStitchMapWithoutReferences) {
  Parts parts = three_streams();
  parts.entries[1].reference_count = 0;
  const Expected<Container> container = parse_container(written(parts, true));
  ASSERT_FALSE(container.ok());
  EXPECT_EQ(container.status().place().patch, 1);
}

TEST(Container, TellsItsVersion) {
  std::vector<uint8_t> bytes = written(three_streams(), false);
  EXPECT_EQ(parse_container(bytes)->version, 2);
  bytes[4] = 1;
  EXPECT_EQ(parse_container(bytes)->version, 1);
}

TEST(Container, RefusesAnotherVersionAsUnsupported) {
  std::vector<uint8_t> bytes = written(three_streams(), false);
  for (const uint8_t version : {uint8_t{0}, uint8_t{3}, uint8_t{255}}) {
    bytes[4] = version;
    EXPECT_EQ(parse_container(bytes).status().code(), StatusCode::kUnsupported) << int{version};
  }
}

TEST(Container, RefusesAStreamCountThatTheBytesCannotHold) {
  std::vector<uint8_t> bytes = written(three_streams(), false);
  bytes[8] = bytes[9] = bytes[10] = bytes[11] = 0xff;
  EXPECT_EQ(parse_container(bytes).status().code(), StatusCode::kInvalidInput);
}

}  // namespace
}  // namespace psplit
