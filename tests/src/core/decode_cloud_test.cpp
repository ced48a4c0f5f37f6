// The core against libdraco, on point clouds of every kind: the order of points and every attribute's bytes
// must be the same.
#include "src/core/decode_cloud.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <set>

#include "tests/src/core/decode_mesh.h"
#include "tests/support/corpus_folder.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

Fault decode_bytes(std::span<const uint8_t> bytes, RawMesh& out) {
  CloudHeader header;
  if (const Fault fault = read_cloud_header(bytes.data(), bytes.size(), header); fault != Fault::kNone)
    return fault;
  return decode<uint32_t>(
      [&](Arena& arena, Patch<uint32_t>& patch) { return decode_cloud<uint32_t>(header, arena, patch); },
      kOneLane, out);
}

// Decodes in exactly the memory that the counts ask for.
template <typename Index>
void expect_cloud_decoded(const DracoStream& stream, const RawMesh& expected) {
  const std::vector<uint8_t> bytes(stream.bytes);  // a block of exactly this size
  CloudHeader header;
  ASSERT_STREQ(fault_text(read_cloud_header(bytes.data(), bytes.size(), header)), fault_text(Fault::kNone));
  if (sizeof(Index) == 2 && !header.fits_16_bits()) return;
  ValueCounts values{expected.point_count, static_cast<uint32_t>(expected.attributes.size()), 0};
  for (const RawAttribute& attribute : expected.attributes)
    values.components += static_cast<uint32_t>(attribute.component_count);
  std::vector<uint8_t> memory(cloud_workspace_bytes<Index>(header, bytes.size(), values));
  Arena arena(memory.data(), memory.size());
  const auto patch = std::make_unique<Patch<Index>>();
  ASSERT_STREQ(fault_text(decode_cloud<Index>(header, arena, *patch)), fault_text(Fault::kNone));
  ASSERT_TRUE(raw_mesh(*patch) == expected);
}

TEST(DecodeCloud, EqualsLibdracoOnEveryKindOfCloud) {
  size_t kd_trees[KdTree::kMostLevel + 1] = {}, sequential = 0, old = 0, seen = 0;
  std::set<uint32_t> counts;
  for_each_draco_cloud([&](const DracoStream& stream) {
    if (testing::Test::HasFatalFailure()) return;
    SCOPED_TRACE(stream.name);
    const RawMesh expected = must(decode_cloud_with_libdraco(stream.bytes));
    // Under sanitizers each cloud has indices of one size.
    const bool both = !kHasSanitizers, odd = ++seen % 2 == 1;
    if (both || odd || expected.point_count > 0xffff) expect_cloud_decoded<uint32_t>(stream, expected);
    if (both || !odd) expect_cloud_decoded<uint16_t>(stream, expected);
    constexpr size_t kMinor = 6, kMethod = 8;
    sequential += stream.bytes[kMethod] == 0;
    old += stream.bytes[kMinor] == 2;
    if (const size_t speed = stream.name.find("kD-tree, speed "); speed != std::string::npos)
      ++kd_trees[10 - std::stoi(stream.name.substr(speed + 15))];
    counts.insert(expected.point_count);
  });
  for (const size_t count : kd_trees) EXPECT_GT(count, 100u);
  EXPECT_GT(sequential, 100u);
  EXPECT_GT(old, 100u);
  for (const uint32_t count : {0u, 1u, 2u, 70'000u}) EXPECT_TRUE(counts.contains(count)) << count;
}

TEST(DecodeCloud, EqualsLibdracoOnTheCorpus) {
  const std::filesystem::path corpus = corpus_folder();
  if (!std::filesystem::exists(corpus)) GTEST_SKIP() << "no corpus at " << corpus;
  size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus)) {
    if (entry.path().extension() != ".drc") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
    RawMesh decoded;
    const Fault fault = decode_bytes(bytes, decoded);
    if (fault == Fault::kNotDraco || fault == Fault::kVersion) continue;  // a mesh, or an older cloud
    EXPECT_STREQ(fault_text(fault), fault_text(Fault::kNone)) << entry.path();
    EXPECT_TRUE(decoded == must(decode_cloud_with_libdraco(bytes))) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 0u);
}

TEST(DecodeCloud, IsNotAMesh) {
  for (const DracoStream& stream : small_draco_clouds()) {
    StreamHeader header;
    EXPECT_EQ(read_stream_header(stream.bytes.data(), stream.bytes.size(), header), Fault::kNotDraco);
  }
  CloudHeader header;
  const std::vector<uint8_t>& mesh = small_draco_streams()[0].bytes;
  EXPECT_EQ(read_cloud_header(mesh.data(), mesh.size(), header), Fault::kNotDraco);
}

TEST(DecodeCloud, RefusesOtherBitstreams) {
  std::vector<uint8_t> bytes = small_draco_clouds()[0].bytes;
  constexpr size_t kMajor = 5, kMinor = 6, kMethod = 8;
  const auto with = [&](size_t at, uint8_t value) {
    std::vector<uint8_t> changed = bytes;
    changed[at] = value;
    CloudHeader header;
    return read_cloud_header(changed.data(), changed.size(), header);
  };
  EXPECT_EQ(with(kMinor, 1), Fault::kVersion);
  EXPECT_EQ(with(kMinor, 4), Fault::kVersion);
  EXPECT_EQ(with(kMajor, 1), Fault::kVersion);
  EXPECT_EQ(with(kMajor, 3), Fault::kVersion);
  EXPECT_EQ(with(kMethod, 2), Fault::kMethod);
  EXPECT_EQ(with(14, 0x80), Fault::kCounts);  // 2^31 points
}

TEST(DecodeCloud, RefusesEveryTruncation) {
  size_t count = 0;
  for (const DracoStream& stream : small_draco_clouds()) {
    if (stream.bytes.size() > 1000 || ++count % 8 != 0) continue;
    for_each_truncation(stream.bytes, [&](const std::vector<uint8_t>& bytes) {
      RawMesh decoded;
      if (decode_bytes(bytes, decoded) != Fault::kNone) return;
      // The last bytes of some streams have no meaning; then libdraco decodes without them, too.
      const std::optional<RawMesh> expected = decode_cloud_with_libdraco(bytes);
      ASSERT_TRUE(expected && *expected == decoded) << stream.name << " cut to " << bytes.size();
    });
  }
  EXPECT_GT(count, 200u);
}

TEST(DecodeCloud, IntegersNeedAPoint) {
  std::vector<uint8_t> bytes = {'D', 'R', 'A', 'C', 'O', 2, 3, 0, 0, 0, 0, 0, 0, 0, 0};      // no points
  for (const int byte : {1, 1, 0, 3, 1, 0, 0}) bytes.push_back(static_cast<uint8_t>(byte));  // of 16 bits
  std::vector<uint8_t> plain = bytes, integers = bytes;
  plain.push_back(0);
  for (const int byte : {1, -2, 1}) integers.push_back(static_cast<uint8_t>(byte));
  RawMesh decoded;
  EXPECT_EQ(decode_bytes(plain, decoded), Fault::kNone);
  EXPECT_TRUE(decode_cloud_with_libdraco(plain));
  EXPECT_EQ(decode_bytes(integers, decoded), Fault::kCounts);
  EXPECT_FALSE(decode_cloud_with_libdraco(integers));
}

// A cloud of few bytes may claim 2^31 equal points: memory bounds it.
TEST(DecodeCloud, ManyPointsNeedMemoryThatTheirBytesDoNotJustify) {
  for (const DracoStream& stream : small_draco_clouds()) {
    std::vector<uint8_t> bytes = stream.bytes;
    constexpr size_t kCount = 11;
    constexpr size_t kFlags = 10;
    // After metadata the number is elsewhere, and without attributes it means nothing.
    if (bytes[kFlags] >= 0x80 || stream.name.find("no attributes") != std::string::npos) continue;
    bytes[kCount + 3] = 0x7f;
    CloudHeader header;
    ASSERT_EQ(read_cloud_header(bytes.data(), bytes.size(), header), Fault::kNone);
    std::vector<uint8_t> memory(size_t{1} << 20);
    Arena arena(memory.data(), memory.size());
    const auto patch = std::make_unique<Patch<uint32_t>>();
    EXPECT_NE(decode_cloud<uint32_t>(header, arena, *patch), Fault::kNone) << stream.name;
  }
}

// libdraco takes memory for all points before it reads one, and for 64 times the square of a tree's axes. It
// may take minutes, or end the program.
bool may_ask_libdraco(const CloudHeader& header, const Patch<uint32_t>& patch, Fault fault) {
  uint32_t components = 0;
  for (size_t i = 0; i < patch.attributes.size(); ++i) components += patch.attributes[i].components;
  return header.point_count < 100'000 && components < 300 && fault != Fault::kWorkspace &&
         fault != Fault::kCounts;
}

// Newer types of attributes, which libdraco has if it was built to transcode. The specification ends at
// generic.
bool has_newer_types(const RawMesh& mesh) {
  return std::ranges::any_of(mesh.attributes, [](const RawAttribute& attribute) { return attribute.type > 4; });
}

// Every mutant is refused, or decodes within its bounds; sanitizers watch them. libdraco has the same verdict,
// and the same values. Metadata is another matter: only libdraco refuses clouds that have an empty entry.
TEST(DecodeCloud, MutantsMeanWhatTheyMeanToLibdraco) {
  const std::vector<DracoStream>& seeds = small_draco_clouds();
  constexpr size_t kMutants = fewer_with_sanitizers(60'000), kMemory = size_t{1} << 22, kFlags = 10;
  std::mt19937 random(1);
  const auto below = [&](size_t bound) { return static_cast<size_t>(random() % bound); };
  std::vector<uint8_t> memory(kMemory);
  const auto patch = std::make_unique<Patch<uint32_t>>();
  size_t accepted = 0, refused = 0;
  for (size_t i = 0; i < kMutants; ++i) {
    const DracoStream& seed = seeds[below(seeds.size())];
    std::vector<uint8_t> bytes = seed.bytes;
    for (size_t edits = 1 + below(3); edits > 0; --edits) {
      const size_t at = below(2) == 0 ? below(std::min<size_t>(bytes.size(), 80)) : below(bytes.size());
      edit(bytes, at, random);
    }
    CloudHeader header;
    if (read_cloud_header(bytes.data(), bytes.size(), header) != Fault::kNone || bytes[kFlags] >= 0x80)
      continue;
    Arena arena(memory.data(), memory.size());
    *patch = {};
    const Fault fault = decode_cloud<uint32_t>(header, arena, *patch);
    if (!may_ask_libdraco(header, *patch, fault)) continue;
    const std::optional<RawMesh> expected = decode_cloud_with_libdraco(bytes);
    if (expected && has_newer_types(*expected)) continue;
    SCOPED_TRACE("mutant " + std::to_string(i) + " of " + seed.name + ": " + fault_text(fault));
    ASSERT_EQ(fault == Fault::kNone, expected.has_value());
    if (expected) {
      ASSERT_TRUE(raw_mesh(*patch) == *expected);
    }
    ++(expected ? accepted : refused);
  }
  EXPECT_GT(accepted, kMutants / 20);
  EXPECT_GT(refused, kMutants / 20);
}

}  // namespace
}  // namespace psplit::core
