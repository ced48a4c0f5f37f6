// The core against libdraco, on streams of every kind that libdraco's encoder writes: faces, the order of
// points and every attribute's bytes must be the same.
#include "src/core/decode_patch.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <random>

#include "tests/src/core/decode_mesh.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

void expect_same_as_libdraco(const DracoStream& stream) {
  const std::optional<RawMesh> expected = decode_with_libdraco(stream.bytes);
  ASSERT_TRUE(expected);
  // A block of exactly this size: the address sanitizer sees an access one byte behind it.
  const std::vector<uint8_t> bytes(stream.bytes);
  StreamHeader header;
  ASSERT_EQ(fault_text(read_stream_header(bytes.data(), bytes.size(), header)), fault_text(Fault::kNone));
  RawMesh decoded;
  ASSERT_EQ(fault_text(decode_in_workspace<uint32_t>(header, bytes.size(), *expected, decoded)),
            fault_text(Fault::kNone));
  ASSERT_TRUE(decoded == *expected);
  if (!header.fits_16_bits()) return;
  ASSERT_EQ(fault_text(decode_in_workspace<uint16_t>(header, bytes.size(), *expected, decoded)),
            fault_text(Fault::kNone));
  ASSERT_TRUE(decoded == *expected);
}

TEST(DecodePatch, EqualsLibdracoOnEveryKindOfStream) {
  for_each_draco_stream(
      [](const DracoStream& stream) {
        if (testing::Test::HasFatalFailure()) return;
        SCOPED_TRACE(stream.name);
        expect_same_as_libdraco(stream);
      },
      StreamSet::kAll);
}

// Each lane takes runs of steps; the rest is shared, or done by the first lane alone. The result is the same in
// any order of the lanes: each stream is decoded in one of them. Under sanitizers only the small streams are.
TEST(DecodePatch, TheLanesOfAWarpTogetherEqualLibdraco) {
#if defined(PSPLIT_ASAN) || defined(PSPLIT_TSAN)
  constexpr StreamSet kSet = StreamSet::kSmall;
#else
  constexpr StreamSet kSet = StreamSet::kAll;
#endif
  size_t count = 0;
  const auto expect_equal = [&]<typename Index>(const DracoStream& stream, const RawMesh& expected,
                                                const StreamHeader& header, Index) {
    RawMesh decoded;
    const LaneOrder order = kLaneOrders[count++ % kLaneOrders.size()];
    ASSERT_EQ(fault_text(decode_by_warp<Index>(header, order, decoded)), fault_text(Fault::kNone));
    ASSERT_TRUE(decoded == expected) << "order " << int{order.kind};
    // If a stream ends early, it does so for all lanes.
    const std::vector<uint8_t> half(stream.bytes.begin(),
                                    stream.bytes.begin() + static_cast<ptrdiff_t>(stream.bytes.size() / 2));
    StreamHeader half_header;
    if (read_stream_header(half.data(), half.size(), half_header) != Fault::kNone) return;
    ASSERT_EQ(fault_text(decode_by_warp<Index>(half_header, order, decoded)),
              fault_text(decode<Index>(half_header, decoded)));
  };
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        if (testing::Test::HasFatalFailure()) return;
        SCOPED_TRACE(stream.name);
        StreamHeader header;
        ASSERT_EQ(fault_text(read_stream_header(stream.bytes.data(), stream.bytes.size(), header)),
                  fault_text(Fault::kNone));
        const std::optional<RawMesh> expected = decode_with_libdraco(stream.bytes);
        ASSERT_TRUE(expected);
        expect_equal(stream, *expected, header, uint32_t{});
        if (header.fits_16_bits()) expect_equal(stream, *expected, header, uint16_t{});
      },
      kSet);
  EXPECT_GT(count, 1000u);
}

// Every mesh stream of version 2.2 in files that others made: .drc files, and streams in glTF's buffers.
TEST(DecodePatch, EqualsLibdracoOnTheCorpus) {
  const std::filesystem::path corpus = PSPLIT_CORPUS;
  if (!std::filesystem::exists(corpus)) GTEST_SKIP() << "no corpus at " << corpus;
  constexpr std::array<uint8_t, 8> kFront = {'D', 'R', 'A', 'C', 'O', 2, 2, 1};
  size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus)) {
    if (!entry.is_regular_file() || entry.path().string().find("malformed") != std::string::npos) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    auto at = bytes.begin();
    while ((at = std::search(at, bytes.end(), kFront.begin(), kFront.end())) != bytes.end()) {
      const auto end = std::search(at + 1, bytes.end(), kFront.begin(), kFront.end());
      const std::vector<uint8_t> stream(at, end);
      at = end;
      SCOPED_TRACE(entry.path().filename().string());
      StreamHeader header;
      ASSERT_EQ(fault_text(read_stream_header(stream.data(), stream.size(), header)), fault_text(Fault::kNone));
      const std::optional<RawMesh> expected = decode_with_libdraco(stream);
      ASSERT_TRUE(expected);
      RawMesh decoded;
      ASSERT_EQ(fault_text(decode<uint32_t>(header, decoded)), fault_text(Fault::kNone));
      ASSERT_TRUE(decoded == *expected);
      const LaneOrder order = kLaneOrders[count++ % kLaneOrders.size()];
      ASSERT_EQ(fault_text(decode_by_warp<uint32_t>(header, order, decoded)), fault_text(Fault::kNone));
      ASSERT_TRUE(decoded == *expected) << "by a warp, order " << int{order.kind};
    }
  }
  EXPECT_GT(count, 0u);
  RecordProperty("streams", static_cast<int>(count));
}

// Streams in step do not disturb each other, even if they have little in common or are broken.
TEST(DecodePatch, StreamsInStepDecodeAsEachAlone) {
  constexpr uint32_t kCount = 3;
  constexpr size_t kMemory = size_t{1} << 24;
  std::vector<std::vector<uint8_t>> streams, memories(kCount, std::vector<uint8_t>(kMemory));
  const auto patches = std::make_unique<Patch<uint16_t>[]>(kCount);
  size_t broken = 0, whole = 0;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        if (testing::Test::HasFatalFailure() || stream.bytes.size() > 20'000) return;
        streams.push_back(stream.bytes);
        if (streams.size() % 5 == 0) streams.back().resize(streams.back().size() / 2);
        StreamHeader headers[kCount];
        Arena arenas[kCount];
        std::optional<PatchDecoder<uint16_t>> decoders[kCount];
        PatchDecoder<uint16_t>* pointers[kCount];
        Fault faults[kCount];
        if (streams.size() < kCount) return;
        for (uint32_t n = 0; n < kCount; ++n) {
          const std::vector<uint8_t>& bytes = streams[streams.size() - kCount + n];
          if (read_stream_header(bytes.data(), bytes.size(), headers[n]) != Fault::kNone) return;
          if (!headers[n].fits_16_bits()) return;
          arenas[n] = Arena(memories[n].data(), kMemory);
          patches[n] = {};
          pointers[n] = &decoders[n].emplace(headers[n], arenas[n], patches[n]);
        }
        decode_in_step(pointers, faults);
        for (uint32_t n = 0; n < kCount; ++n) {
          RawMesh alone;
          ASSERT_EQ(fault_text(decode<uint16_t>(headers[n], alone)), fault_text(faults[n])) << stream.name;
          const bool is_whole = faults[n] == Fault::kNone;
          ASSERT_TRUE(!is_whole || raw_mesh(patches[n]) == alone) << stream.name;
          ++(is_whole ? whole : broken);
        }
      },
      StreamSet::kSmall);
  EXPECT_GT(whole, 100u);
  EXPECT_GT(broken, 30u);
}

TEST(DecodePatch, RefusesEveryTruncation) {
  size_t count = 0;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        // Every length of some streams, so that all features are cut somewhere.
        if (stream.bytes.size() > 1500 || ++count % 8 != 0) return;
        for (size_t length = 0; length < stream.bytes.size(); ++length) {
          const std::vector<uint8_t> bytes(stream.bytes.begin(),
                                           stream.bytes.begin() + static_cast<ptrdiff_t>(length));
          StreamHeader header;
          RawMesh decoded;
          if (read_stream_header(bytes.data(), bytes.size(), header) != Fault::kNone) continue;
          if (decode<uint32_t>(header, decoded) != Fault::kNone) continue;
          // The last bytes of some streams have no meaning; then libdraco decodes without them, too.
          const std::optional<RawMesh> expected = decode_with_libdraco(bytes);
          ASSERT_TRUE(expected && *expected == decoded) << stream.name << " cut to " << length;
        }
      },
      StreamSet::kSmall);
}

// Flips, overwrites, inserts and removes bytes of real streams. Every mutant must be refused, or decode within
// its bounds and in time and memory that its size justifies; sanitizers watch the bounds. If libdraco accepts a
// mutant as well, both must agree. libdraco decodes only some of the mutants, because it is slow and trusts its
// input.
// libdraco has a meaning for schemes, transforms and codings of symbols that do not exist, or that do not fit.
TEST(DecodePatch, BrokenMethodsMeanWhatTheyMeanToLibdraco) {
  constexpr size_t kFrontBytes = 11, kMostBytes = 200, kStreams = mutants_to_try(40);
  size_t streams = 0, decoded_count = 0;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        if (stream.bytes.size() > kMostBytes || streams == kStreams) return;
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
      },
      StreamSet::kSmall);
  EXPECT_GT(decoded_count, kStreams);
}

TEST(DecodePatch, RefusesMutantsOrDecodesThemWithinTheirBounds) {
  std::vector<std::vector<uint8_t>> seeds;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        if (stream.bytes.size() < 4000) seeds.push_back(stream.bytes);
      },
      StreamSet::kSmall);
  constexpr size_t kMutants = mutants_to_try(200'000), kMemory = size_t{1} << 22;
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
      switch (below(4)) {
        case 0: bytes[at] ^= static_cast<uint8_t>(1u << below(8)); break;
        case 1: bytes[at] = static_cast<uint8_t>(random()); break;
        case 2: bytes.insert(bytes.begin() + static_cast<ptrdiff_t>(at), static_cast<uint8_t>(random())); break;
        default:
          if (bytes.size() > 1) bytes.erase(bytes.begin() + static_cast<ptrdiff_t>(at));
      }
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
