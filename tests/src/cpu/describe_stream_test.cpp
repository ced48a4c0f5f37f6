// The core's descriptions of streams, against libdraco's and against the sections of the streams.

#include <algorithm>
#include <set>

#include "encoder/fields/expand_container.h"
#include "encoder/libdraco/draco_backend.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/draco_features.h"
#include "tests/support/draco_streams.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

TEST(DescribeStream, EqualsWhatLibdracoSaysOfEveryKindOfStream) {
  std::set<StreamCoding> codings;
  size_t quantized = 0, exact = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    SCOPED_TRACE(stream.name);
    const auto described = must(describe_stream(stream.bytes));
    const auto expected = must(describe_draco_stream(stream.bytes));
    EXPECT_TRUE(described == expected);

    const auto features = must(read_features(stream.bytes));
    EXPECT_EQ(described.coding, !features.edgebreaker        ? StreamCoding::kSequential
                                : features.connectivity == 2 ? StreamCoding::kEdgebreakerValence
                                                             : StreamCoding::kEdgebreaker);
    ASSERT_EQ(described.attributes.size(), features.attributes.size());
    for (size_t i = 0; i < features.attributes.size(); ++i) {
      EXPECT_EQ(described.attributes[i].unique_id, features.attributes[i].unique_id);
      EXPECT_EQ(static_cast<int>(described.attributes[i].semantic), features.attributes[i].type);
      EXPECT_EQ(static_cast<int>(described.attributes[i].type), features.attributes[i].data_type);
      EXPECT_EQ(described.attributes[i].components, features.attributes[i].component_count);
      EXPECT_EQ(described.attributes[i].bits, std::max(features.attributes[i].bits, 0));
      ++(described.attributes[i].bits > 0 ? quantized : exact);
    }
    codings.insert(described.coding);
  }
  EXPECT_EQ(codings.size(), 3u);
  EXPECT_GT(quantized, 100u);
  EXPECT_GT(exact, 100u);
}

// The smallest stream of one kind that a glTF asset may hold.
std::vector<uint8_t> smallest_stream(bool is_sequential) {
  std::vector<uint8_t> smallest;
  for (const DracoStream& stream : small_draco_streams()) {
    if (!smallest.empty() && stream.bytes.size() >= smallest.size()) continue;
    const auto description = describe_stream(stream.bytes);
    if (description && (description->coding == StreamCoding::kSequential) == is_sequential &&
        description->face_count > 1 && gltf_attributes(description->attributes))
      smallest = stream.bytes;
  }
  return smallest;
}

TEST(DescribeStream, RefusesWhatTheBackendRefuses) {
  struct Decoder {
    DescribeStream describe;
    DecodeBackend backend;
  };
  const Decoder decoders[] = {{describe_stream, cpu_backend()}, {describe_draco_stream, draco_backend()}};
  for (const bool is_sequential : {false, true}) {
    const std::vector<uint8_t> whole = smallest_stream(is_sequential);
    for (const auto& [describe, backend] : decoders) {
      SCOPED_TRACE(backend.name + (is_sequential ? ", sequential" : ", Edgebreaker"));
      const auto description = must(describe(whole));
      const auto usual = gltf_attributes(description.attributes);
      for (size_t at = 0; at < whole.size(); ++at) {
        SCOPED_TRACE(at);
        const std::vector<uint8_t> part(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(at));
        EXPECT_EQ(describe(part).status().code(), StatusCode::kInvalidInput);
        std::vector<uint8_t> broken = whole;
        broken[at] = 0xff;
        const auto described = describe(broken);
        const auto requests = described ? gltf_attributes(described->attributes) : usual;
        if (!requests) continue;
        const auto decoded = decode_stream(backend, broken, *requests);
        EXPECT_EQ(described.status().to_string(), decoded.status().to_string());
      }
    }
  }
}

TEST(DescribePatch, SaysWhatIsSaidOfTheDracoStream) {
  const ThreadPool pool(2);
  size_t condensed = 0, ordinary = 0, grids = 0;
  for (const CondensedSample& sample : condensed_samples(pool)) {
    SCOPED_TRACE(sample.original.name);
    const PatchContainer container = must(open_container(sample.container));
    for (uint32_t i = 0; i < container.entries.size(); ++i) {
      const StreamDescription description = must(describe_patch(container, i));
      EXPECT_TRUE(description == must(describe_stream(must(expand_patch(container, i))))) << i;
      EXPECT_TRUE(description == must(describe_patch(container.alone(i), 0))) << i;
      ++(container.entries[i].is_condensed ? condensed : ordinary);
      for (const StreamAttribute& attribute : description.attributes) grids += attribute.origin.size();
    }
  }
  EXPECT_GT(condensed, 20u);
  EXPECT_GT(ordinary, 0u);
  EXPECT_GT(grids, 60u);
}

TEST(DescribePatch, NamesThePatchOfAnError) {
  const CondensedSample& sample = condensed_samples(ThreadPool(2)).front();
  PatchContainer container = must(open_container(sample.container));
  const uint32_t last = container.patch_count() - 1;
  container.streams[last] = container.streams[last].first(1);
  container.headers[last].condensed.bytes = {container.streams[last].data(), 1};
  const Status status = describe_patch(container, last).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(status.place().patch, last);
}

// The outlines of all streams, and what decoding them finds.
template <typename Check>
void for_each_outline(const std::vector<DracoStream>& streams, Check check) {
  for (const DracoStream& stream : streams) {
    SCOPED_TRACE(stream.name);
    StreamDescription description;
    std::vector<StoredValues> stored;
    const Status decoded = decode_geometry(
        stream.bytes,
        [&](const StreamDescription& of, std::span<const StoredValues> values) -> Expected<GeometryPlaces> {
          description = of;
          stored.assign(values.begin(), values.end());
          return cancelled();
        });
    const Expected<StreamOutline> outline = outline_stream(stream.bytes);
    if (decoded.code() != StatusCode::kCancelled) {
      EXPECT_EQ(outline.status().to_string(), decoded.to_string());
      continue;
    }
    ASSERT_TRUE(outline) << outline.status().to_string();
    ASSERT_EQ(outline->stored.size(), stored.size());
    for (size_t i = 0; i < stored.size(); ++i) {
      EXPECT_EQ(outline->stored[i].value_count, stored[i].value_count);
      EXPECT_EQ(outline->stored[i].one_a_point, stored[i].one_a_point);
      EXPECT_EQ(outline->stored[i].has_integers, stored[i].has_integers);
    }
    check(stream, outline->description, description);
  }
}

TEST(OutlineStream, IsTheDescriptionOfEveryStreamButKdTrees) {
  size_t meshes = 0, clouds = 0, trees = 0;
  for_each_outline(small_draco_streams(), [&](const auto&, const auto& outline, const auto& description) {
    EXPECT_TRUE(outline == description);
    ++meshes;
  });
  for_each_outline(small_draco_clouds(), [&](const auto&, const auto& outline, auto description) {
    const bool is_tree = description.coding == StreamCoding::kCloudKdTree;
    for (StreamAttribute& attribute : description.attributes)
      if (is_tree) attribute.bits = 0, attribute.range = 0, attribute.origin = {};
    EXPECT_TRUE(outline == description);
    ++(is_tree ? trees : clouds);
  });
  EXPECT_GT(meshes, 100u);
  EXPECT_GT(clouds, 20u);
  EXPECT_GT(trees, 20u);
}

TEST(OutlineStream, RefusesTruncatedStreamsAndNoneThatDecodes) {
  for (const bool is_sequential : {false, true}) {
    const std::vector<uint8_t> whole = smallest_stream(is_sequential);
    for (size_t at = 0; at < whole.size(); ++at) {
      SCOPED_TRACE(at);
      EXPECT_FALSE(outline_stream(std::span(whole).first(at)));
      std::vector<uint8_t> broken = whole;
      broken[at] = 0xff;
      const auto described = describe_stream(broken);
      if (!described) continue;
      EXPECT_TRUE(must(outline_stream(broken)).description == *described);
    }
  }
}

TEST(DescribeStream, LeavesOlderStreamsToLibdraco) {
  std::vector<uint8_t> bytes = smallest_stream(false);
  bytes[6] = 1;  // 2.1
  const Status older = describe_stream(bytes).status();
  EXPECT_EQ(older.code(), StatusCode::kUnsupported);
  EXPECT_EQ(older.message(),
            "Draco stream: of bitstream 2.1, which is older than 2.2, the only one that is decoded");
}

}  // namespace
}  // namespace psplit
