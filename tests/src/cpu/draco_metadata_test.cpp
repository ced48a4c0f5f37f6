// Metadata of streams, against libdraco's and against trees that a test writes.
#include "tests/support/draco_metadata.h"

#include <random>

#include "psplit/decode.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

constexpr size_t kFlags = 10, kFront = 11;

std::vector<DracoStream> streams_with_metadata() {
  std::vector<DracoStream> streams;
  for (const auto* all : {&small_draco_streams(), &small_draco_clouds()})
    for (const DracoStream& stream : *all)
      if (stream.bytes[kFlags] >= 0x80) streams.push_back(stream);
  return streams;
}

// The front of a mesh with metadata.
std::vector<uint8_t> front() { return {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0x80}; }

void append_name(std::vector<uint8_t>& bytes, const std::string& name) {
  bytes.push_back(static_cast<uint8_t>(name.size()));
  bytes.insert(bytes.end(), name.begin(), name.end());
}
void append_entry(std::vector<uint8_t>& bytes, const std::string& name, const std::vector<uint8_t>& value) {
  append_name(bytes, name);
  bytes.push_back(static_cast<uint8_t>(value.size()));
  bytes.insert(bytes.end(), value.begin(), value.end());
}

TEST(DracoMetadata, AreThoseThatLibdracoReads) {
  size_t count = 0;
  for (const DracoStream& stream : streams_with_metadata()) {
    SCOPED_TRACE(stream.name);
    StreamMetadata metadata = must(read_metadata(stream.bytes));
    EXPECT_FALSE(metadata.geometry.entries.empty());
    EXPECT_FALSE(metadata.attributes.empty());
    sort_parts(metadata);
    EXPECT_TRUE(metadata == must(read_metadata_with_libdraco(stream.bytes)));
    ++count;
  }
  EXPECT_GT(count, 10u);
}

TEST(DracoMetadata, AreEmptyIfAStreamHasNone) {
  const std::vector<uint8_t>& bytes = small_draco_clouds()[0].bytes;
  ASSERT_LT(bytes[kFlags], 0x80);
  EXPECT_TRUE(must(read_metadata(bytes)) == StreamMetadata());
}

TEST(DracoMetadata, AreATree) {
  std::vector<uint8_t> bytes = front();
  bytes.insert(bytes.end(), {1, 9});  // one attribute has metadata, of the unique id 9
  bytes.push_back(1);
  append_entry(bytes, "name", {'x'});
  bytes.push_back(0);
  bytes.push_back(2);  // entries of the geometry: the second one replaces the first one
  append_entry(bytes, "twice", {1});
  append_entry(bytes, "twice", {2, 3});
  bytes.push_back(2);  // its parts
  append_name(bytes, "first");
  bytes.insert(bytes.end(), {0, 1});
  append_name(bytes, "inner");
  bytes.push_back(1);
  append_entry(bytes, "", {5});
  bytes.push_back(0);
  append_name(bytes, "second");
  bytes.insert(bytes.end(), {0, 0});
  for (int i = 0; i < 4; ++i) bytes.push_back(0);  // the rest of the stream

  const StreamMetadata metadata = must(read_metadata(bytes));
  ASSERT_EQ(metadata.attributes.size(), 1u);
  EXPECT_EQ(metadata.attributes[0].unique_id, 9u);
  EXPECT_EQ(*metadata.attributes[0].metadata.find_entry("name"), std::vector<uint8_t>{'x'});
  EXPECT_EQ(metadata.attributes[0].metadata.find_entry("names"), nullptr);
  EXPECT_EQ(*metadata.geometry.find_entry("twice"), (std::vector<uint8_t>{2, 3}));
  ASSERT_EQ(metadata.geometry.parts.size(), 2u);
  EXPECT_EQ(metadata.geometry.parts[1].name, "second");
  EXPECT_EQ(metadata.geometry.find_part("third"), nullptr);
  const Metadata* inner = metadata.geometry.find_part("first")->find_part("inner");
  ASSERT_NE(inner, nullptr);
  EXPECT_EQ(*inner->find_entry(""), std::vector<uint8_t>{5});
}

TEST(DracoMetadata, HaveNoEmptyValues) {
  for (const size_t size : {0u, 1u}) {
    std::vector<uint8_t> bytes = front();
    bytes.insert(bytes.end(), {0, 1});
    append_entry(bytes, "empty", std::vector<uint8_t>(size, 7));
    bytes.resize(bytes.size() + 100);
    EXPECT_EQ(read_metadata(bytes).ok(), size > 0);
    EXPECT_EQ(read_metadata_with_libdraco(bytes).has_value(), size > 0);
  }
}

// Parts in each other, `depth` times.
std::vector<uint8_t> nested(size_t depth) {
  std::vector<uint8_t> bytes = front();
  bytes.insert(bytes.end(), {0, 0});
  for (size_t i = 0; i < depth; ++i) {
    bytes.push_back(1);
    append_name(bytes, "in");
    bytes.push_back(0);
  }
  bytes.push_back(0);
  bytes.resize(bytes.size() + 100);
  return bytes;
}

TEST(DracoMetadata, NestAThousandTimes) {
  for (const size_t depth : {1000u, 1001u}) {
    EXPECT_TRUE(read_metadata(nested(depth)).ok());
    EXPECT_TRUE(read_metadata_with_libdraco(nested(depth)));
  }
  for (const size_t depth : {1002u, 100'000u}) {
    EXPECT_EQ(read_metadata(nested(depth)).status().to_string(),
              "Draco stream: metadata with an empty value, or that repeat a name or nest too deeply");
    EXPECT_FALSE(read_metadata_with_libdraco(nested(depth)));
  }
}

TEST(DracoMetadata, OfOtherBitstreamsOrOfNoStreamAreRefused) {
  std::vector<uint8_t> bytes = streams_with_metadata()[0].bytes;
  bytes[6] = 4;  // 2.4
  EXPECT_EQ(read_metadata(bytes).status().code(), StatusCode::kUnsupported);
  bytes[7] = 2;  // neither a mesh nor a cloud
  EXPECT_EQ(read_metadata(bytes).status().code(), StatusCode::kInvalidInput);
  bytes[0] = 'd';
  EXPECT_EQ(read_metadata(bytes).status().code(), StatusCode::kInvalidInput);
}

// Mutants have libdraco's verdict, except that it refuses empty values.
TEST(DracoMetadata, MutantsMeanWhatTheyMeanToLibdraco) {
  const std::vector<DracoStream> seeds = streams_with_metadata();
  std::mt19937 random(1);
  size_t accepted = 0, refused = 0;
  constexpr size_t kMutants = fewer_with_sanitizers(20'000);
  for (size_t i = 0; i < kMutants; ++i) {
    std::vector<uint8_t> bytes = seeds[random() % seeds.size()].bytes;
    for (size_t edits = 1 + random() % 3; edits > 0; --edits)
      edit(bytes, kFront + random() % (bytes.size() - kFront), random);
    Expected<StreamMetadata> metadata = read_metadata(bytes);
    const std::optional<StreamMetadata> expected = read_metadata_with_libdraco(bytes);
    ++(expected ? accepted : refused);
    ASSERT_TRUE(metadata || !expected) << i;
    if (!expected) continue;
    sort_parts(*metadata);
    ASSERT_TRUE(*metadata == *expected) << i;
  }
  EXPECT_GT(accepted, kMutants / 20);
  EXPECT_GT(refused, kMutants / 20);
}

}  // namespace
}  // namespace psplit
