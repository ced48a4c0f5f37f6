// Values at borders are stored once, and streams come back from them bit for bit.
#include "encoder/condensing/border_symbols.h"

#include <algorithm>

#include "src/condensed/expand.h"
#include "src/container/patch_container.h"
#include "tests/support/expect.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

struct Patches {
  std::vector<std::vector<uint8_t>> streams;
  std::vector<DecodedCounts> counts;
};

Patches patches_of(const PatchContainer& container) {
  Patches patches;
  for (size_t i = 0; i < container.entries.size(); ++i) {
    const StreamEntry& entry = container.entries[i];
    patches.streams.emplace_back(container.streams[i].begin(), container.streams[i].end());
    patches.counts.push_back({entry.face_count, entry.point_count, entry.reference_count, container.stitch[i]});
  }
  return patches;
}

BorderPart border_part(const Patches& patches, uint32_t stream) {
  const Expected<DracoFields> fields = read_fields(patches.streams[stream]);
  const auto source =
      DecodedSource::decode(patches.streams[stream], patches.counts[stream].point_count, *fields);
  return make_border_part(*source, patches.counts[stream], stream, fields->attributes[0].components);
}

size_t total_bytes(const CondensedStreams& condensed) {
  size_t bytes = condensed.head.size();
  for (const std::vector<uint8_t>& stream : condensed.bytes) bytes += stream.size();
  return bytes;
}

TEST(BorderPart, StreamsComeBackFromValuesThatAreStoredOnce) {
  size_t with_borders = 0, places = 0, own_places = 0;
  const ThreadPool pool(2);
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const PatchContainer container = must(open_container(sample.encoded.container));
    const Patches patches = patches_of(container);
    const CondensedStreams condensed = condense(patches.streams, patches.counts, true, pool);
    if (condensed.head.empty()) continue;
    const CondensedHead head = must(read_condensed_head(condensed.head));
    if (!head.has_borders) continue;
    ++with_borders;
    for (uint32_t i = 0; i < container.patch_count(); ++i) {
      ASSERT_NE(condensed.is_condensed[i], 0);
      const BorderPart part = border_part(patches, i);
      places += part.is_own.size();
      own_places += static_cast<size_t>(std::ranges::count(part.is_own, 1));
      CondensedPatch stream{condensed.bytes[i], condensed.skeleton[i], patches.counts[i].face_count,
                            patches.counts[i].point_count, part.values};
      const Expected<std::vector<uint8_t>> expanded = expand_stream(head, stream);
      ASSERT_TRUE(expanded.ok()) << expanded.status().message();
      EXPECT_TRUE(*expanded == patches.streams[i]);
      // Values of another number of places are refused.
      stream.known = {};
      EXPECT_EQ(expand_stream(head, stream).ok(), part.values.empty());
    }
    std::vector<DecodedCounts> without_stitch = patches.counts;
    for (DecodedCounts& counts : without_stitch) counts.stitch = {};
    const CondensedStreams plain = condense(patches.streams, without_stitch, true, pool);
    EXPECT_LE(total_bytes(condensed), total_bytes(plain) + plain.head.size());
  }
  EXPECT_GT(with_borders, 5u);
  EXPECT_LT(own_places, places);
}

// A map that pairs points with different values does not describe shared values.
TEST(BorderPart, PlacesWithOtherValuesDoNotAgree) {
  size_t checked = 0;
  for (const PatchedSample& sample : patched_samples(ThreadPool(2))) {
    const Expected<PatchContainer> container = open_container(sample.encoded.container);
    if (container->has_residue || container->patch_count() < 3) continue;
    const Patches patches = patches_of(*container);
    std::vector<BorderPart> parts;
    bool is_edgebreaker = true;
    for (const core::StreamHeader& header : container->headers) is_edgebreaker &= header.edgebreaker;
    for (uint32_t i = 0; is_edgebreaker && i < patches.streams.size(); ++i) {
      const Expected<DracoFields> fields = read_fields(patches.streams[i]);
      is_edgebreaker = fields.ok() && fields->attributes[0].skeleton.allows_creation_order();
      if (is_edgebreaker) parts.push_back(border_part(patches, i));
    }
    if (!is_edgebreaker) continue;
    constexpr uint32_t kComponents = 3;
    for (uint32_t i = 0; i < parts.size(); ++i) {
      EXPECT_TRUE(parts[i].agrees(patches.counts[i], i, kComponents, parts));
      const auto shared = std::ranges::find(parts[i].is_own, 0) - parts[i].is_own.begin();
      if (shared == std::ssize(parts[i].is_own)) continue;
      BorderPart other = parts[i];
      ++other.values[static_cast<size_t>(shared) * kComponents];
      EXPECT_FALSE(other.agrees(patches.counts[i], i, kComponents, parts));
      ++checked;
    }
  }
  EXPECT_GT(checked, 5u);
}

}  // namespace
}  // namespace psplit
