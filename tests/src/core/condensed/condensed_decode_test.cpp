// Condensed streams decode to what libdraco decodes from the Draco streams that they were made from: the same
// faces, points and bytes of every attribute.

#include <map>
#include <memory>
#include <optional>
#include <random>

#include "encoder/condensing/condense.h"
#include "encoder/fields/expand.h"
#include "src/container/condensed_head.h"
#include "src/core/condensed/condensed_header.h"
#include "tests/src/core/decode_mesh.h"
#include "tests/support/container_of_streams.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/sanitizers.h"

namespace psplit::core {
namespace {

// Streams that share a head. Streams that cannot be condensed are left out.
struct Batch {
  CondensedHead head;
  struct Stream {
    std::string name;
    std::vector<uint8_t> bytes;
    uint32_t skeleton = 0;
    RawMesh expected;

    uint32_t face_count() const { return static_cast<uint32_t>(expected.faces.size()); }
  };
  std::vector<Stream> streams;

  Fault read_header(const Stream& stream, std::span<const uint8_t> bytes, StreamHeader& header) const {
    const std::vector<uint8_t>& skeleton = head.skeletons[stream.skeleton];
    return read_condensed_header({skeleton.data(), skeleton.size()}, {bytes.data(), bytes.size()},
                                 head.models(), stream.face_count(), stream.expected.point_count, header,
                                 header.condensed);
  }
};

// The small streams in batches of 60. A process condenses them once.
const std::vector<Batch>& batches(bool smallest) {
  static std::map<bool, std::vector<Batch>> made;
  std::vector<Batch>& found = made[smallest];
  if (!found.empty()) return found;
  const std::vector<DracoStream>& all = small_draco_streams();
  for (size_t first = 0; first < all.size(); first += 60) {
    std::vector<std::vector<uint8_t>> streams;
    std::vector<StreamEntry> rows;
    std::vector<RawMesh> expected;
    for (size_t i = first; i < std::min(first + 60, all.size()); ++i) {
      streams.push_back(all[i].bytes);
      expected.push_back(must(decode_with_libdraco(all[i].bytes)));
      rows.push_back({.face_count = static_cast<uint32_t>(expected.back().faces.size()),
                      .point_count = expected.back().point_count});
    }
    const CondensedStreams condensed = condense(container_of_streams(streams, rows), smallest, ThreadPool(1));
    Batch batch;
    for (size_t i = 0; i < streams.size(); ++i)
      if (condensed.entries[i].is_condensed)
        batch.streams.push_back(
            {all[first + i].name, condensed.bytes[i], condensed.entries[i].skeleton, std::move(expected[i])});
    if (batch.streams.empty()) continue;
    batch.head = must(read_condensed_head(condensed.head));
    found.push_back(std::move(batch));
  }
  return found;
}

template <typename Index>
void expect_decoded(const Batch& batch, const Batch::Stream& stream, const StreamHeader& header) {
  RawMesh decoded;
  ASSERT_EQ(fault_text(decode_in_workspace<Index>(header, stream.bytes.size(), stream.expected, decoded)),
            fault_text(Fault::kNone));
  ASSERT_TRUE(decoded == stream.expected);
  static size_t count = 0;
  const LaneOrder order = kLaneOrders[count++ % kLaneOrders.size()];
  ASSERT_EQ(fault_text(decode_by_warp<Index>(header, order, decoded)), fault_text(Fault::kNone));
  ASSERT_TRUE(decoded == stream.expected) << "by a warp, order " << int{order.kind};
  // If its end is missing, the lanes agree about it.
  const std::vector<uint8_t> half(stream.bytes.begin() + static_cast<ptrdiff_t>(stream.bytes.size() / 2),
                                  stream.bytes.end());
  StreamHeader half_header;
  if (batch.read_header(stream, half, half_header) != Fault::kNone) return;
  ASSERT_EQ(fault_text(decode_by_warp<Index>(half_header, order, decoded)),
            fault_text(decode<Index>(half_header, decoded)));
}

void expect_batches_decode(bool smallest) {
  size_t count = 0, with_creation = 0, with_seams = 0, with_flags = 0, with_valence = 0, with_sets = 0;
  for (const Batch& batch : batches(smallest)) {
    for (const Batch::Stream& stream : batch.streams) {
      if (testing::Test::HasFatalFailure()) return;
      SCOPED_TRACE(stream.name);
      const std::vector<uint8_t> bytes(stream.bytes);  // of exactly this size
      StreamHeader header;
      ASSERT_EQ(fault_text(batch.read_header(stream, bytes, header)), fault_text(Fault::kNone));
      // Under sanitizers each stream has indices of one size.
      const bool both = !kHasSanitizers, small = header.fits_16_bits() && count % 2 == 0;
      if (both || !small) expect_decoded<uint32_t>(batch, stream, header);
      if (both ? header.fits_16_bits() : small) expect_decoded<uint16_t>(batch, stream, header);
      ++count;
      with_seams += header.attribute_data_count > 0;
      with_valence += batch.head.has_valence_contexts;
    }
    for (const AttributeModel& model : batch.head.attributes) {
      with_creation += model.by_creation;
      with_flags += model.has_flags;
      with_sets += model.set_count > 1;
    }
  }
  EXPECT_GT(count, 300u);
  EXPECT_GT(with_creation, 0u);
  EXPECT_GT(with_seams, 100u);
  EXPECT_GT(with_flags, 0u);
  EXPECT_GT(with_sets, 0u);
  testing::Test::RecordProperty("streams", static_cast<int>(count));
  testing::Test::RecordProperty("with_valence", static_cast<int>(with_valence));
}

TEST(CondensedDecode, EqualsLibdraco) { expect_batches_decode(false); }
TEST(CondensedDecode, EqualsLibdracoInTheSmallestCoding) { expect_batches_decode(true); }

TEST(CondensedDecode, StreamsInStepDecodeAsEachAlone) {
  constexpr uint32_t kCount = InStep::kCount;
  InStep in_step;
  for (const Batch& batch : batches(false)) {
    std::vector<std::vector<uint8_t>> bytes;
    for (const Batch::Stream& stream : batch.streams) {
      bytes.push_back(stream.bytes);
      if (bytes.size() % 4 == 0) bytes.back()[bytes.back().size() / 2] ^= 1;
    }
    for (size_t i = 0; i + kCount <= batch.streams.size(); ++i) {
      StreamHeader headers[kCount];
      bool fits = true;
      for (uint32_t n = 0; n < kCount; ++n)
        fits = fits && batch.read_header(batch.streams[i + n], bytes[i + n], headers[n]) == Fault::kNone &&
               headers[n].fits_16_bits() && bytes[i + n].size() < 20'000;
      if (!fits) continue;
      ASSERT_NO_FATAL_FAILURE(in_step.expect_as_alone(headers));
    }
  }
  EXPECT_GT(in_step.whole, 100u);
  EXPECT_GT(in_step.broken, 30u);
}

// Every mutant must be refused, or decode within its bounds; sanitizers watch the bounds. expand_stream and the
// core must agree: libdraco decodes what expands to the same mesh.
TEST(CondensedDecode, RefusesMutantsOrDecodesThemWithinTheirBounds) {
  constexpr size_t kMutants = fewer_with_sanitizers(3000), kMemory = size_t{1} << 22;  // of each batch
  std::mt19937 random(1);
  const auto below = [&](size_t bound) { return static_cast<size_t>(random() % bound); };
  std::vector<uint8_t> memory(kMemory);
  const auto patch = std::make_unique<Patch<uint16_t>>();
  size_t accepted = 0, compared = 0, refused = 0;
  for (const Batch& batch : batches(false)) {
    for (size_t i = 0; i < kMutants; ++i) {
      const Batch::Stream& seed = batch.streams[below(batch.streams.size())];
      if (seed.bytes.size() > 4000) continue;
      std::vector<uint8_t> bytes = seed.bytes;
      for (size_t edits = 1 + below(3); edits > 0; --edits) {
        // The numbers are at the end.
        const size_t at =
            below(2) == 0 ? bytes.size() - 1 - below(std::min<size_t>(bytes.size(), 16)) : below(bytes.size());
        edit(bytes, at, random);
      }
      bytes.shrink_to_fit();
      StreamHeader header;
      ++refused;
      if (batch.read_header(seed, bytes, header) != Fault::kNone || !header.fits_16_bits()) continue;
      Arena arena(memory.data(), memory.size());
      *patch = {};
      if (decode_patch<uint16_t>(header, arena, *patch) != Fault::kNone) continue;
      if (patch->point_count != seed.expected.point_count) continue;  // the caller's check
      const RawMesh decoded = raw_mesh(*patch);
      ++accepted, --refused;
      const Expected<std::vector<uint8_t>> expanded =
          expand_stream(batch.head, {bytes, seed.skeleton, seed.face_count(), seed.expected.point_count});
      if (!expanded.ok()) continue;
      const std::optional<RawMesh> expected = decode_with_libdraco(*expanded);
      if (!expected) continue;
      ++compared;
      ASSERT_TRUE(decoded == *expected) << seed.name << ", mutant " << i;
    }
  }
  EXPECT_GT(refused, fewer_with_sanitizers(1000));
  EXPECT_GT(accepted, fewer_with_sanitizers(20));
  EXPECT_GT(compared, fewer_with_sanitizers(10));
  RecordProperty("compared", static_cast<int>(compared));
}

// Of 4 or 8 sets the last one is taken away: the same bits choose it.
TEST(CondensedDecode, RefusesASetOfTablesThatDoesNotExist) {
  size_t refused = 0;
  for (const Batch& batch : batches(false)) {
    Batch fewer = batch;
    for (AttributeModel& model : fewer.head.attributes)
      if (model.set_count > 2) --model.set_count;
    for (const Batch::Stream& stream : fewer.streams) {
      StreamHeader header;
      ASSERT_EQ(fault_text(fewer.read_header(stream, stream.bytes, header)), fault_text(Fault::kNone));
      RawMesh decoded;
      const Fault fault = decode<uint32_t>(header, decoded);
      const bool is_expanded = expand_stream(fewer.head, {stream.bytes, stream.skeleton, stream.face_count(),
                                                          stream.expected.point_count})
                                   .ok();
      ASSERT_EQ(is_expanded, fault == Fault::kNone) << stream.name;
      if (fault == Fault::kNone) continue;
      EXPECT_EQ(fault_text(fault), fault_text(Fault::kAttribute)) << stream.name;
      ++refused;
    }
  }
  EXPECT_GT(refused, 0u);
}

TEST(CondensedDecode, RefusesEveryTruncation) {
  for (const Batch& batch : batches(false)) {
    for (const Batch::Stream& stream : batch.streams) {
      if (stream.bytes.size() > 400) continue;
      for (size_t length = 0; length < stream.bytes.size(); ++length)
        for (const bool front : {false, true}) {
          const auto begin =
              stream.bytes.begin() + static_cast<ptrdiff_t>(front ? 0 : stream.bytes.size() - length);
          const std::vector<uint8_t> bytes(begin, begin + static_cast<ptrdiff_t>(length));
          StreamHeader header;
          RawMesh decoded;
          if (batch.read_header(stream, bytes, header) != Fault::kNone) continue;
          // Cut bits are other numbers, which seldom say a mesh of the same counts.
          if (decode<uint32_t>(header, decoded) == Fault::kNone) {
            EXPECT_TRUE(front) << stream.name << " cut to " << length;
          }
        }
    }
  }
}

}  // namespace
}  // namespace psplit::core
