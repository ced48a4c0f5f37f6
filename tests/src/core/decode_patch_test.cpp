// The core against libdraco, on streams of every kind that libdraco's encoder writes: faces, the order of
// points and every attribute's bytes must be the same.
#include "src/core/decode_patch.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <span>

#include "tests/src/core/decode_mesh.h"
#include "tests/support/corpus_streams.h"
#include "tests/support/draco_features.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

StreamHeader header_of(std::span<const uint8_t> bytes) {
  StreamHeader header;
  EXPECT_EQ(fault_text(read_stream_header(bytes.data(), bytes.size(), header)), fault_text(Fault::kNone));
  return header;
}

template <typename Index>
void expect_decoded(const DracoStream& stream, const RawMesh& expected) {
  // A block of exactly this size: the address sanitizer sees an access one byte after it.
  const std::vector<uint8_t> bytes(stream.bytes);
  RawMesh decoded;
  ASSERT_EQ(fault_text(decode_in_workspace<Index>(header_of(bytes), bytes.size(), expected, decoded)),
            fault_text(Fault::kNone));
  ASSERT_TRUE(decoded == expected);
}

// Each lane takes runs of steps; the rest is shared, or done by the first lane alone. The result is the same in
// any order of the lanes: each stream is decoded in one of them.
template <typename Index>
void expect_decoded_by_a_warp(const DracoStream& stream, const RawMesh& expected, size_t& count) {
  RawMesh decoded;
  const LaneOrder order = kLaneOrders[count++ % kLaneOrders.size()];
  ASSERT_EQ(fault_text(decode_by_warp<Index>(header_of(stream.bytes), order, decoded)),
            fault_text(Fault::kNone));
  ASSERT_TRUE(decoded == expected) << "order " << int{order.kind};
  // If a stream ends early, it does so for all lanes.
  const std::vector<uint8_t> half(stream.bytes.begin(), stream.bytes.begin() + std::ssize(stream.bytes) / 2);
  StreamHeader header;
  if (read_stream_header(half.data(), half.size(), header) != Fault::kNone) return;
  ASSERT_EQ(fault_text(decode_by_warp<Index>(header, order, decoded)),
            fault_text(decode<Index>(header, decoded)));
}

// Under sanitizers each stream has indices of one size on one lane, and a warp decodes every third stream. A
// warp has indices of one size for each stream.
void expect_equal_to_libdraco(StreamSet set) {
  constexpr bool kEverything = !kHasSanitizers;
  size_t count = 0, seen = 0;
  const auto expect_equal = [&](const DracoStream& stream) {
    if (testing::Test::HasFatalFailure()) return;
    SCOPED_TRACE(stream.name);
    const RawMesh expected = must(decode_with_libdraco(stream.bytes));
    const bool fits_16_bits = header_of(stream.bytes).fits_16_bits(), odd = ++seen % 2 == 1;
    if (kEverything || odd || !fits_16_bits) expect_decoded<uint32_t>(stream, expected);
    if (fits_16_bits && (kEverything || !odd)) expect_decoded<uint16_t>(stream, expected);
    if (!kEverything && seen % 3 != 0) return;
    if (fits_16_bits && odd) {
      expect_decoded_by_a_warp<uint16_t>(stream, expected, count);
    } else {
      expect_decoded_by_a_warp<uint32_t>(stream, expected, count);
    }
  };
  for_each_draco_stream(expect_equal, set);
  EXPECT_GT(count, set == StreamSet::kAll ? 1000u : 150u);
}

TEST(DecodePatch, EqualsLibdracoOnEveryKindOfStream) { expect_equal_to_libdraco(StreamSet::kSmall); }

TEST(DecodePatch, EqualsLibdracoOnAllStreamsTakesLong) { expect_equal_to_libdraco(StreamSet::kAll); }

TEST(DecodePatch, EqualsLibdracoOnTheCorpus) {
  size_t count = 0;
  for_each_corpus_stream([&](const std::string& file, const std::vector<uint8_t>& stream) {
    const RawMesh expected = must(decode_with_libdraco(stream));
    RawMesh decoded;
    ASSERT_EQ(fault_text(decode<uint32_t>(header_of(stream), decoded)), fault_text(Fault::kNone)) << file;
    ASSERT_TRUE(decoded == expected) << file;
    const LaneOrder order = kLaneOrders[count++ % kLaneOrders.size()];
    ASSERT_EQ(fault_text(decode_by_warp<uint32_t>(header_of(stream), order, decoded)),
              fault_text(Fault::kNone));
    ASSERT_TRUE(decoded == expected) << file << " by a warp, order " << int{order.kind};
  });
}

TEST(DecodePatch, StreamsInStepDecodeAsEachAlone) {
  constexpr uint32_t kCount = InStep::kCount;
  InStep in_step;
  std::vector<std::vector<uint8_t>> streams;
  for (const DracoStream& stream : small_draco_streams()) {
    if (stream.bytes.size() > 20'000) continue;
    SCOPED_TRACE(stream.name);
    streams.push_back(stream.bytes);
    if (streams.size() % 5 == 0) streams.back().resize(streams.back().size() / 2);
    if (streams.size() < kCount) continue;
    StreamHeader headers[kCount];
    bool fits = true;
    for (uint32_t n = 0; n < kCount; ++n) {
      const std::vector<uint8_t>& bytes = streams[streams.size() - kCount + n];
      fits = fits && read_stream_header(bytes.data(), bytes.size(), headers[n]) == Fault::kNone &&
             headers[n].fits_16_bits();
    }
    if (!fits) continue;
    ASSERT_NO_FATAL_FAILURE(in_step.expect_as_alone(headers));
  }
  EXPECT_GT(in_step.whole, 100u);
  EXPECT_GT(in_step.broken, 30u);
}

// The symbols that follow tags are known late: one thread takes their steps beside those that traversals have
// left, which streams in step have no more. So a stream of several tagged attributes, the last among them, must
// mean the same both ways, and have the same fault if its bytes are damaged.
TEST(DecodePatch, TraversalsMayEndBesideSymbolsAfterTags) {
  InStep in_step;
  std::mt19937 random(1);
  size_t streams = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    if (stream.bytes.size() > 20'000) continue;
    const StreamFeatures features = must(read_features(stream.bytes));
    const auto is_tagged = [](const AttributeFeatures& attribute) { return attribute.symbols == 0; };
    const auto tagged = std::ranges::count_if(features.attributes, is_tagged);
    const bool walks = std::ranges::any_of(
        features.attributes, [](const AttributeFeatures& attribute) { return attribute.traversal == 0; });
    if (!features.edgebreaker || !walks || tagged < 2 || !is_tagged(features.attributes.back())) continue;
    SCOPED_TRACE(stream.name);
    ++streams;
    for (size_t round = 0; round < 20; ++round) {
      std::vector<std::vector<uint8_t>> damaged(InStep::kCount, stream.bytes);
      StreamHeader headers[InStep::kCount];
      bool fits = true;
      for (uint32_t n = 0; n < InStep::kCount; ++n) {
        std::vector<uint8_t>& bytes = damaged[n];
        for (uint32_t edits = n; edits > 0; --edits) edit(bytes, random() % bytes.size(), random);
        fits = fits && read_stream_header(bytes.data(), bytes.size(), headers[n]) == Fault::kNone &&
               headers[n].fits_16_bits();
      }
      if (!fits) continue;
      ASSERT_NO_FATAL_FAILURE(in_step.expect_as_alone(headers));
    }
  }
  EXPECT_GT(streams, 10u);
  EXPECT_GT(in_step.whole, 200u);
  EXPECT_GT(in_step.broken, 200u);
}

TEST(DecodePatch, RefusesEveryTruncation) {
  size_t count = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    // Every length of some streams, so that all features are cut somewhere.
    if (stream.bytes.size() > 1500 || ++count % 8 != 0) continue;
    for_each_truncation(stream.bytes, [&](const std::vector<uint8_t>& bytes) {
      StreamHeader header;
      RawMesh decoded;
      if (read_stream_header(bytes.data(), bytes.size(), header) != Fault::kNone) return;
      if (decode<uint32_t>(header, decoded) != Fault::kNone) return;
      // The last bytes of some streams have no meaning; then libdraco decodes without them, too.
      const std::optional<RawMesh> expected = decode_with_libdraco(bytes);
      ASSERT_TRUE(expected && *expected == decoded) << stream.name << " cut to " << bytes.size();
    });
  }
}

// libdraco has a meaning for schemes, transforms and codings of symbols that do not exist, or that do not fit.
TEST(DecodePatch, MutantsOfMethodsMeanWhatTheyMeanToLibdraco) {
  constexpr size_t kFrontBytes = 11, kMostBytes = 200, kStreams = fewer_with_sanitizers(40);
  size_t streams = 0, decoded_count = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    if (stream.bytes.size() > kMostBytes || streams == kStreams) continue;
    ++streams;
    std::vector<uint8_t> bytes = stream.bytes;
    for (size_t at = kFrontBytes; at < bytes.size(); ++at) {
      const uint8_t before = bytes[at];
      for (const int other : {before + 1, before - 1, before ^ 0x80, 0xff}) {
        bytes[at] = static_cast<uint8_t>(other);
        StreamHeader header;
        if (bytes[at] == before || read_stream_header(bytes.data(), bytes.size(), header) != Fault::kNone ||
            !header.fits_16_bits())
          continue;
        RawMesh decoded;
        const Fault fault = decode<uint16_t>(header, decoded);
        if (fault != Fault::kMethod && fault != Fault::kNone) continue;
        const std::optional<RawMesh> expected = decode_with_libdraco(bytes);
        const std::string name = stream.name + ", byte " + std::to_string(at);
        ASSERT_TRUE(fault == Fault::kNone || !expected) << name;
        if (fault != Fault::kNone || !expected) continue;
        ++decoded_count;
        ASSERT_TRUE(decoded == *expected) << name;
      }
      bytes[at] = before;
    }
  }
  EXPECT_GT(decoded_count, kStreams);
}

// Flips, overwrites, inserts and removes bytes of real streams. Every mutant must be refused, or decode within
// its bounds and in time and memory that its size justifies; sanitizers watch the bounds. If libdraco accepts a
// mutant as well, both must agree. libdraco decodes only some of the mutants, because it is slow and trusts its
// input.
TEST(DecodePatch, RefusesMutantsOrDecodesThemWithinTheirBounds) {
  std::vector<std::vector<uint8_t>> seeds;
  for (const DracoStream& stream : small_draco_streams())
    if (stream.bytes.size() < 4000) seeds.push_back(stream.bytes);
  constexpr size_t kMutants = fewer_with_sanitizers(200'000), kMemory = size_t{1} << 22;
  std::mt19937 random(1);
  const auto below = [&](size_t bound) { return static_cast<size_t>(random() % bound); };
  std::vector<uint8_t> memory(kMemory);
  const auto patch = std::make_unique<Patch<uint16_t>>();
  size_t accepted = 0, compared = 0;
  for (size_t i = 0; i < kMutants; ++i) {
    std::vector<uint8_t> bytes = seeds[below(seeds.size())];
    for (size_t edits = 1 + below(3); edits > 0; --edits) {
      // A byte of headers and tables means most.
      const size_t at = below(2) == 0 ? below(std::min<size_t>(bytes.size(), 80)) : below(bytes.size());
      edit(bytes, at, random);
    }
    StreamHeader header;
    if (read_stream_header(bytes.data(), bytes.size(), header) != Fault::kNone || !header.fits_16_bits())
      continue;
    Arena arena(memory.data(), memory.size());
    *patch = {};
    if (decode_patch<uint16_t>(header, arena, *patch) != Fault::kNone) continue;
    const RawMesh decoded = raw_mesh(*patch);
    ++accepted;
    if (i % 8 != 0) continue;
    const std::optional<RawMesh> expected = decode_with_libdraco(bytes);
    if (!expected) continue;
    ++compared;
    ASSERT_TRUE(decoded == *expected) << "mutant " << i;
    EXPECT_EQ(fault_text(expect_walk_by_definition(*patch, arena)), fault_text(Fault::kNone)) << "mutant " << i;
  }
  // A test that sees nothing but refusals would show little.
  EXPECT_GT(accepted, kMutants / 100);
  EXPECT_GT(compared, kMutants / 1000);
}

}  // namespace
}  // namespace psplit::core
