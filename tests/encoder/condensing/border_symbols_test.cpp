// Values at borders are stored once, and streams come back from them bit for bit.
#include "encoder/condensing/border_symbols.h"

#include <algorithm>

#include "encoder/condensing/condense.h"
#include "encoder/fields/expand.h"
#include "src/container/patch_container.h"
#include "tests/support/expect.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

BorderPart border_part(const PatchContainer& container, uint32_t stream) {
  const std::span<const uint8_t> bytes = container.streams[stream];
  const Expected<DracoFields> fields = read_fields(bytes);
  const auto source = DecodedSource::decode(bytes, container.entries[stream].point_count, *fields);
  return make_border_part(*source, container, stream, fields->attributes[0].components);
}

bool has_borders(const CondensedStreams& condensed) {
  return !condensed.head.empty() && must(read_condensed_head(condensed.head)).has_borders;
}

PatchContainer without_stitch_map(PatchContainer container) {
  for (std::span<const uint8_t>& map : container.stitch) map = {};
  return container;
}

size_t total_bytes(const CondensedStreams& condensed) {
  size_t bytes = condensed.head.size();
  for (const StreamEntry& entry : condensed.entries) bytes += entry.stream_bytes;
  return bytes;
}

TEST(BorderPart, StreamsComeBackFromValuesThatAreStoredOnce) {
  size_t with_borders = 0, places = 0, own_places = 0;
  const ThreadPool pool(2);
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
    const CondensedStreams condensed = condense(container, true, pool);
    if (!has_borders(condensed)) continue;
    const CondensedHead head = must(read_condensed_head(condensed.head));
    ++with_borders;
    for (uint32_t i = 0; i < container.patch_count(); ++i) {
      const StreamEntry& entry = condensed.entries[i];
      ASSERT_TRUE(entry.is_condensed);
      const BorderPart part = border_part(container, i);
      places += part.is_own.size();
      own_places += static_cast<size_t>(std::ranges::count(part.is_own, 1));
      CondensedPatch stream{condensed.bytes[i], entry.skeleton, entry.face_count, entry.point_count,
                            part.values};
      const Expected<std::vector<uint8_t>> expanded = expand_stream(head, stream);
      ASSERT_TRUE(expanded.ok()) << expanded.status().message();
      EXPECT_TRUE(std::ranges::equal(*expanded, container.streams[i]));
      // Values of another number of places are refused.
      stream.known = {};
      EXPECT_EQ(expand_stream(head, stream).ok(), part.values.empty());
    }
    const CondensedStreams plain = condense(without_stitch_map(container), true, pool);
    EXPECT_LE(total_bytes(condensed), total_bytes(plain) + plain.head.size());
  }
  EXPECT_GT(with_borders, 5u);
  EXPECT_LT(own_places, places);
}

// Values at borders are stored once for all patches, or for none.
TEST(BorderPart, IsLeftOutIfOnePatchCannotHaveIt) {
  const ThreadPool pool(2);
  const auto expect_no_borders = [&](const PatchContainer& container) {
    const CondensedStreams condensed = condense(container, true, pool);
    const CondensedStreams plain = condense(without_stitch_map(container), true, pool);
    EXPECT_FALSE(plain.head.empty());
    EXPECT_EQ(condensed.head, plain.head);
    EXPECT_EQ(condensed.entries, plain.entries);
    EXPECT_EQ(condensed.bytes, plain.bytes);
  };
  size_t checked = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
    if (checked == 3 || container.patch_count() < 5 || !has_borders(condense(container, true, pool))) continue;
    SCOPED_TRACE(sample.name);
    const uint32_t last = container.patch_count() - 1;
    DracoFields fields = must(read_fields(container.streams[last]));
    if (fields.attributes[0].skeleton.scheme != core::Scheme::kParallelogram) continue;
    ++checked;
    PatchContainer other_map = container;
    other_map.stitch[last] = container.stitch[last - 1];
    expect_no_borders(other_map);
    // Another encoder stores a larger range of values than it needs. The stream does not come back.
    --fields.attributes[0].wrap_min;
    const std::vector<uint8_t> larger_range = must(write_fields(fields));
    PatchContainer other_encoder = container;
    other_encoder.streams[last] = larger_range;
    other_encoder.entries[last].stream_bytes = static_cast<uint32_t>(larger_range.size());
    expect_no_borders(other_encoder);
  }
  EXPECT_EQ(checked, 3u);
}

// A map that pairs points with different values does not describe shared values.
TEST(BorderPart, PlacesWithOtherValuesDoNotAgree) {
  size_t checked = 0;
  for (const PatchedSample& sample : patched_samples(ThreadPool(2))) {
    const Expected<PatchContainer> container = open_container(sample.encoded.pieces[0].bytes);
    if (container->has_residue || container->patch_count() < 3) continue;
    std::vector<BorderPart> parts;
    bool is_edgebreaker = true;
    for (const core::StreamHeader& header : container->headers) is_edgebreaker &= header.edgebreaker;
    for (uint32_t i = 0; is_edgebreaker && i < container->streams.size(); ++i) {
      const Expected<DracoFields> fields = read_fields(container->streams[i]);
      is_edgebreaker = fields.ok() && fields->attributes[0].skeleton.allows_creation_order();
      if (is_edgebreaker) parts.push_back(border_part(*container, i));
    }
    if (!is_edgebreaker) continue;
    constexpr uint32_t kComponents = 3;
    for (uint32_t i = 0; i < parts.size(); ++i) {
      EXPECT_TRUE(parts[i].agrees(*container, i, kComponents, parts));
      const auto shared = std::ranges::find(parts[i].is_own, 0) - parts[i].is_own.begin();
      if (shared == std::ssize(parts[i].is_own)) continue;
      BorderPart other = parts[i];
      ++other.values[static_cast<size_t>(shared) * kComponents];
      EXPECT_FALSE(other.agrees(*container, i, kComponents, parts));
      ++checked;
    }
  }
  EXPECT_GT(checked, 5u);
}

}  // namespace
}  // namespace psplit
