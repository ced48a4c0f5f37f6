// Streams that libdraco's encoder wrote are condensed, and come back bit for bit. Streams that would not come
// back are stored.
#include "encoder/condensing/condense.h"

#include <algorithm>
#include <random>

#include "encoder/fields/draco_fields.h"
#include "encoder/fields/expand.h"
#include "encoder/libdraco/draco_backend.h"
#include "tests/support/container_of_streams.h"
#include "tests/support/draco_streams.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

PatchContainer container_of(std::span<const Bytes> streams) {
  std::vector<StreamEntry> rows;
  for (const Bytes& stream : streams) {
    const StreamDescription of_stream = must(describe_draco_stream(stream));
    rows.push_back({static_cast<uint32_t>(stream.size()), of_stream.face_count, of_stream.point_count, 0, 0});
  }
  return container_of_streams(streams, std::move(rows));
}

int64_t condensed_count(std::span<const StreamEntry> entries) {
  return std::ranges::count_if(entries, &StreamEntry::is_condensed);
}

// Condenses the streams as one primitive, and expands them again.
CondensedStreams condense_and_expand(std::span<const Bytes> streams, bool smallest = false) {
  CondensedStreams condensed = condense(container_of(streams), smallest, ThreadPool(1));
  EXPECT_EQ(condensed.bytes.size(), streams.size());
  Expected<CondensedHead> head = CondensedHead();
  if (!condensed.head.empty()) head = read_condensed_head(condensed.head);
  EXPECT_TRUE(head.ok()) << head.status().message();
  size_t before = 0, after = condensed.head.size();
  for (size_t i = 0; i < streams.size(); ++i) {
    before += streams[i].size();
    const StreamEntry& entry = condensed.entries[i];
    after += entry.stream_bytes;
    EXPECT_EQ(entry.is_condensed, !condensed.bytes[i].empty());
    EXPECT_EQ(entry.stream_bytes, entry.is_condensed ? condensed.bytes[i].size() : streams[i].size());
    if (!entry.is_condensed) {
      EXPECT_EQ(entry.skeleton, 0);
      continue;
    }
    const Expected<Bytes> expanded =
        expand_stream(*head, {condensed.bytes[i], entry.skeleton, entry.face_count, entry.point_count});
    EXPECT_TRUE(expanded.ok()) << expanded.status().message();
    EXPECT_TRUE(expanded.ok() && *expanded == streams[i]);
  }
  EXPECT_EQ(condensed.head.empty(), condensed_count(condensed.entries) == 0);
  EXPECT_LE(after, before);
  return condensed;
}

// Whether the rules of condensed streams allow the stream.
bool has_rules_of_condensed_streams(const Bytes& stream) {
  const Expected<DracoFields> fields = read_fields(stream);
  if (!fields || fields->possible_levels == 0) return false;
  return std::ranges::none_of(fields->attributes,
                              [](const AttributeFields& attribute) { return attribute.component_bytes > 4; });
}

// Counts condensed streams by feature. It shows that the tests meet all features.
struct Features {
  size_t streams = 0, handles = 0, valence = 0, components = 0, interior = 0, mixed_interior = 0, seams = 0,
         raw = 0, creases = 0, orientations = 0, flips = 0, one_face = 0;
  uint32_t schemes = 0, normal_schemes = 0;

  void count(const Bytes& stream) {
    const Expected<DracoFields> fields = read_fields(stream);
    const auto any = [](const Bytes& flags) { return std::ranges::count(flags, 1) > 0; };
    const bool is_mixed = any(fields->start_faces) && std::ranges::count(fields->start_faces, 0) > 0;
    ++streams;
    handles += !fields->split_events.empty();
    valence += std::ranges::any_of(fields->symbol_lists, [](const Bytes& list) { return !list.empty(); });
    components += fields->start_faces.size() > 1;
    interior += any(fields->start_faces);
    mixed_interior += is_mixed;
    seams += std::ranges::any_of(fields->seams, any);
    one_face += fields->face_count == 1;
    for (size_t i = 0; i < fields->attributes.size(); ++i) {
      const AttributeFields& attribute = fields->attributes[i];
      raw += !attribute.raw.empty();
      creases += std::ranges::any_of(attribute.creases, any);
      orientations += any(attribute.same_orientations);
      flips += any(attribute.flips);
      const auto scheme = static_cast<uint32_t>(static_cast<int>(attribute.skeleton.scheme) + 2);
      (attribute.skeleton.coding == core::Coding::kNormal ? normal_schemes : schemes) |= 1u << scheme;
    }
  }
};

// Copies of a stream together save far more than their head takes, of a small one many.
TEST(Condense, EveryKindOfStreamIsCondensedAndComesBack) {
  Features condensed;
  size_t larger = 0;  // condensed, some streams of a few large numbers would get larger
  for (const DracoStream& stream : small_draco_streams()) {
    SCOPED_TRACE(stream.name);
    const std::vector<Bytes> copies(stream.bytes.size() < 1500 ? 20 : 5, stream.bytes);
    const CondensedStreams result = condense_and_expand(copies, condensed.streams % 2 == 1);
    const bool is_condensed = result.entries[0].is_condensed;
    const bool may_be_condensed = has_rules_of_condensed_streams(stream.bytes);
    EXPECT_TRUE(may_be_condensed || !is_condensed);
    if (is_condensed) condensed.count(stream.bytes);
    if (may_be_condensed && !is_condensed) ++larger;
  }
  EXPECT_GT(condensed.streams, 100u);
  EXPECT_LT(larger, condensed.streams / 10);
  for (const size_t feature : {condensed.handles, condensed.valence, condensed.components, condensed.interior,
                               condensed.mixed_interior, condensed.seams, condensed.raw, condensed.creases,
                               condensed.orientations, condensed.flips, condensed.one_face})
    EXPECT_GT(feature, 0u);
  const auto bit = [](core::Scheme scheme) { return 1u << (static_cast<int>(scheme) + 2); };
  using core::Scheme;
  EXPECT_EQ(condensed.schemes, bit(Scheme::kNone) | bit(Scheme::kDifference) | bit(Scheme::kParallelogram) |
                                   bit(Scheme::kConstrainedMultiParallelogram) | bit(Scheme::kTexCoords));
  EXPECT_EQ(condensed.normal_schemes,
            bit(Scheme::kNone) | bit(Scheme::kDifference) | bit(Scheme::kGeometricNormal));
}

// Streams of all kinds as one primitive: they have many skeletons, some with more attributes than others.
TEST(Condense, StreamsOfDifferentKindsShareModels) {
  constexpr size_t kTogether = 100;
  std::vector<Bytes> streams;
  size_t condensed = 0, skeletons = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    streams.push_back(stream.bytes);
    if (streams.size() < kTogether) continue;
    const CondensedStreams result = condense_and_expand(streams);
    condensed += static_cast<size_t>(condensed_count(result.entries));
    for (const StreamEntry& entry : result.entries)
      skeletons = std::max<size_t>(skeletons, entry.skeleton + 1u);
    streams.clear();
  }
  EXPECT_GT(condensed, 100u);
  EXPECT_GT(skeletons, 5u);
}

// Streams with handles, seams and more, as patches of one primitive would be.
std::vector<Bytes> some_streams(size_t count) {
  std::vector<Bytes> streams;
  for (const DracoStream& stream : small_draco_streams()) {
    if (stream.bytes.size() > 500 && has_rules_of_condensed_streams(stream.bytes))
      streams.push_back(stream.bytes);
  }
  EXPECT_GT(streams.size(), count);
  streams.resize(count);
  return streams;
}

TEST(Condense, TheNumberOfThreadsChangesNothing) {
  const std::vector<Bytes> streams = some_streams(60);
  const CondensedStreams one = condense(container_of(streams), false, ThreadPool(1));
  EXPECT_FALSE(one.head.empty());
  for (const int threads : {2, 7}) {
    const CondensedStreams several = condense(container_of(streams), false, ThreadPool(threads));
    EXPECT_EQ(several.head, one.head);
    EXPECT_EQ(several.bytes, one.bytes);
    EXPECT_EQ(several.entries, one.entries);
  }
}

// Another encoder may store a larger range of values than it needs. Values in the order of creation give the
// range that libdraco's encoder finds, so such a stream does not come back.
TEST(Condense, AStreamThatDoesNotComeBackIsStored) {
  Bytes stream;
  DracoFields fields;
  for (const DracoStream& candidate : small_draco_streams()) {
    Expected<DracoFields> read = read_fields(candidate.bytes);
    // Values of a flat grid are always stored in the order of creation.
    if (!stream.empty() || !read || !candidate.name.starts_with("grid: ")) continue;
    if (read->attributes[0].skeleton.scheme != core::Scheme::kParallelogram) continue;
    stream = candidate.bytes;
    fields = std::move(*read);
  }
  ASSERT_FALSE(stream.empty());
  std::vector<Bytes> streams(40, stream);
  --fields.attributes[0].wrap_min;
  streams[7] = *write_fields(fields);
  ASSERT_NE(streams[7], stream);
  const CondensedStreams result = condense_and_expand(streams);
  EXPECT_FALSE(result.entries[7].is_condensed);
  EXPECT_EQ(condensed_count(result.entries), 39);
}

TEST(Condense, AStreamWhoseCountsDifferFromItsRowIsStored) {
  const std::vector<Bytes> streams = some_streams(40);
  PatchContainer container = container_of(streams);
  ++container.entries[3].face_count;
  const CondensedStreams result = condense(container, false, ThreadPool(1));
  EXPECT_FALSE(result.entries[3].is_condensed);
  EXPECT_TRUE(result.bytes[3].empty());
  EXPECT_GT(condensed_count(result.entries), 10);
}

TEST(Condense, NothingIsCondensedIfTheHeadTakesMoreThanIsSaved) {
  size_t stored = 0, condensed = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    if (!has_rules_of_condensed_streams(stream.bytes) || stream.bytes.size() > 300) continue;
    const CondensedStreams result = condense_and_expand(std::span(&stream.bytes, 1));
    EXPECT_EQ(!result.entries[0].is_condensed, result.head.empty());
    ++(result.head.empty() ? stored : condensed);
    if (!result.head.empty()) {
      EXPECT_LT(result.head.size() + result.bytes[0].size(), stream.bytes.size());
    }
  }
  EXPECT_GT(stored, 0u);
  EXPECT_GT(condensed, 0u);
  EXPECT_TRUE(condense({}, false, ThreadPool(1)).bytes.empty());
}

TEST(Condense, MoreSkeletonsThanAHeadHolds) {
  const std::vector<Bytes> streams = some_streams(40);
  std::vector<Bytes> many;
  for (uint32_t i = 0; i < 300; ++i) {
    Bytes stream = streams[i % 5];
    stream.push_back(static_cast<uint8_t>(i));  // decoders ignore bytes after the end
    if (i >= 256) stream.push_back(1);
    many.push_back(std::move(stream));
  }
  const CondensedStreams result = condense_and_expand(many);
  ASSERT_FALSE(result.head.empty());
  EXPECT_EQ(condensed_count(std::span(result.entries).last(45)), 0);
}

// Hostile bytes give an error or a stream, and nothing else.
TEST(Expand, MutantsAreRefusedOrExpanded) {
  const std::vector<Bytes> streams = some_streams(60);
  const CondensedStreams condensed = condense(container_of(streams), false, ThreadPool(1));
  const CondensedHead head = must(read_condensed_head(condensed.head));
  std::mt19937 random(1);
  const auto below = [&](size_t end) { return static_cast<size_t>(random() % end); };
  size_t refused = 0, expanded = 0;
  for (size_t i = 0; i < streams.size(); ++i) {
    const StreamEntry& entry = condensed.entries[i];
    if (!entry.is_condensed) continue;
    for (int round = 0; round < 60; ++round) {
      Bytes bytes = condensed.bytes[i];
      uint32_t faces = entry.face_count, points = entry.point_count, skeleton = entry.skeleton;
      switch (round % 5) {
        case 0: bytes[below(bytes.size())] ^= static_cast<uint8_t>(1u << below(8)); break;
        case 1: bytes.resize(below(bytes.size())); break;
        case 2:
          bytes[bytes.size() - 1 - below(std::min<size_t>(bytes.size(), 12))] = static_cast<uint8_t>(random());
          break;
        case 3: (round % 2 == 0 ? faces : points) = static_cast<uint32_t>(random()) >> below(32); break;
        default: skeleton = static_cast<uint32_t>(below(head.skeletons.size() + 1)); break;
      }
      const Expected<Bytes> result = expand_stream(head, {bytes, skeleton, faces, points});
      EXPECT_TRUE(result.ok() || !result.status().message().empty());
      ++(result.ok() ? expanded : refused);
    }
  }
  EXPECT_GT(refused, 1000u);
  EXPECT_GT(expanded, 0u);
}

}  // namespace
}  // namespace psplit
