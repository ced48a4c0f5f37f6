// The sum of what the stages declare is enough for every stream, and not far above what decoding takes.
#include "src/core/workspace.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/draco_streams.h"

namespace psplit::core {
namespace {

// Decodes in the first `size` bytes, and walks the border there.
template <typename Index>
bool decodes_in(std::vector<uint8_t>& memory, size_t size, const StreamHeader& header, Patch<Index>& patch) {
  Arena arena(memory.data(), size);
  patch = {};
  const Fault fault = decode_patch<Index>(header, arena, patch);
  EXPECT_TRUE(fault == Fault::kNone || fault == Fault::kWorkspace) << fault_text(fault);
  View<Index> walk;
  return fault == Fault::kNone && walk_border(patch, arena, walk) == Fault::kNone;
}

// Bytes over all streams.
struct Totals {
  size_t sum = 0, used = 0, fixed = 0;
};

template <typename Index>
void expect_close(const DracoStream& stream, const StreamHeader& header, Totals& totals) {
  static std::vector<uint8_t> memory(size_t{1} << 26);
  const auto patch = std::make_unique<Patch<Index>>();
  ASSERT_TRUE(decodes_in(memory, memory.size(), header, *patch));
  ValueCounts values{patch->point_count, static_cast<uint32_t>(patch->attributes.size()), 0};
  for (size_t i = 0; i < patch->attributes.size(); ++i) values.components += patch->attributes[i].components;
  const size_t sum = workspace_bytes<Index>(header, stream.bytes.size(), values);
  ASSERT_TRUE(decodes_in(memory, sum, header, *patch));
  size_t used = sum, too_little = 0;
  while (used - too_little > used / 64 + 1) {
    const size_t middle = too_little + (used - too_little) / 2;
    (decodes_in(memory, middle, header, *patch) ? used : too_little) = middle;
  }
  // Each sequence of symbols may have a large table if it may have many symbols. Marks of the faces of more
  // than 8,192 do not depend on their number.
  const size_t sequences = 1 + values.attributes + (header.valence ? ValenceSymbols<Index>::kLists : 0);
  const uint64_t of_faces = header.edgebreaker ? header.counts.symbol_count : 3 * header.counts.face_count;
  const size_t fixed =
      SymbolSequence::bytes(sequences, uint64_t{values.points} * values.components + of_faces) +
      (header.counts.face_count > 8192 ? size_t{40} << 10 : size_t{2} << 10);
  EXPECT_LE(sum, 6 * used + fixed);  // streams without integers use the least of it
  totals.sum += sum, totals.used += used, totals.fixed += fixed;
}

TEST(Workspace, IsEnoughForEveryStreamAndNotFarAbove) {
  Totals totals;
  for (const DracoStream& stream : small_draco_streams()) {
    SCOPED_TRACE(stream.name);
    StreamHeader header;
    ASSERT_EQ(read_stream_header(stream.bytes.data(), stream.bytes.size(), header), Fault::kNone);
    expect_close<uint32_t>(stream, header, totals);
    if (header.fits_16_bits()) expect_close<uint16_t>(stream, header, totals);
  }
  EXPECT_GT(totals.used, 0u);
  EXPECT_LE(totals.sum, 2 * totals.used + totals.fixed);
}

}  // namespace
}  // namespace psplit::core
