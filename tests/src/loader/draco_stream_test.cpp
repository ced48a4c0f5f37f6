// Stock Draco streams by the loader, against libdraco.

#include <atomic>

#include "encoder/libdraco/draco_backend.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "tests/src/loader/buffers.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/draco_streams.h"
#include "tests/support/mutants.h"
#include "tests/support/older_stream.h"
#include "tests/support/patched_samples.h"
#include "tests/support/same_bits.h"

namespace psplit {
namespace {

struct Sample {
  std::string name;
  std::vector<uint8_t> bytes;
  std::vector<AttributeRequest> requests;
  Mesh expected;  // by libdraco
  bool is_sequential;

  PrimitiveSource source(uint64_t points = 0, uint64_t indices = 0) const {
    return {bytes, requests, points, indices, Compression::kDraco};
  }
  PrimitiveSource exact_source() const { return source(expected.point_count, 3 * expected.faces.size()); }
};

// Streams of every kind that libdraco writes and a glTF asset may hold.
const std::vector<Sample>& stream_samples() {
  static const std::vector<Sample> all = [] {
    std::vector<Sample> found;
    for (const DracoStream& stream : small_draco_streams()) {
      const StreamDescription description = must(describe_draco_stream(stream.bytes));
      const auto requests = gltf_attributes(description.attributes);
      if (!requests) continue;
      Expected<Mesh> mesh = decode_stream(draco_backend(), stream.bytes, *requests);
      // Some streams hold numbers that no glTF type can hold.
      if (!mesh || mesh->faces.empty()) continue;
      found.push_back({stream.name, stream.bytes, *requests, std::move(*mesh),
                       description.coding == StreamCoding::kSequential});
    }
    return found;
  }();
  return all;
}

// The smallest of its kind.
const Sample& smallest(bool is_sequential) {
  const Sample* least = nullptr;
  for (const Sample& sample : stream_samples())
    if (sample.is_sequential == is_sequential &&
        (least == nullptr || sample.bytes.size() < least->bytes.size()))
      least = &sample;
  return *least;
}

Mesh decoded(const Sample& sample, const CompressedPrimitive& primitive, uint32_t index_bytes = 4) {
  Buffers buffers(sample.requests, primitive.point_count(), primitive.face_count(), index_bytes, 3);
  must(primitive.decode(buffers.out));
  return buffers.mesh(sample.requests, primitive.point_count());
}

TEST(LoaderOfDracoStreams, DecodesIntoBuffersWhatLibdracoDecodes) {
  size_t sequential = 0, narrow = 0;
  for (const Sample& sample : stream_samples()) {
    SCOPED_TRACE(sample.name);
    // The first source has the accessors' counts, the second has none.
    for (const PrimitiveSource& source : {sample.exact_source(), sample.source()}) {
      const auto primitive = must(CompressedPrimitive::open(source));
      ASSERT_EQ(primitive.point_count(), sample.expected.point_count);
      ASSERT_EQ(primitive.face_count(), sample.expected.faces.size());
      EXPECT_EQ(primitive.compression(), Compression::kDraco);
      EXPECT_TRUE(same_bits(decoded(sample, primitive), sample.expected));
      if (primitive.least_index_bytes() > 2) continue;
      EXPECT_TRUE(same_bits(decoded(sample, primitive, 2), sample.expected));
      ++narrow;
    }
    sequential += sample.is_sequential;
  }
  EXPECT_GT(sequential, 10u);
  EXPECT_GT(stream_samples().size(), sequential + 100);
  EXPECT_GT(narrow, 100u);
}

TEST(LoaderOfDracoStreams, IsOnePatch) {
  const Sample& sample = smallest(false);
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(sample.exact_source()));
  ASSERT_EQ(primitive.patch_count(), 1u);
  EXPECT_FALSE(primitive.has_residue());
  const PatchSizes sizes = primitive.patch(0);
  EXPECT_EQ(sizes.face_count, sample.expected.faces.size());
  EXPECT_EQ(sizes.point_count, sample.expected.point_count);
  EXPECT_EQ(sizes.owned_point_count, sample.expected.point_count);
  EXPECT_EQ(sizes.stream_bytes, sample.bytes.size());
  Buffers buffers(sample.requests, sizes.point_count, sizes.face_count);
  ASSERT_TRUE(primitive.decode_patch(0, buffers.out).ok());
  EXPECT_TRUE(same_bits(buffers.mesh(sample.requests, sizes.point_count), sample.expected));
}

// A model with both extensions is one batch. The error of one primitive does not affect another.
TEST(LoaderOfDracoStreams, DecodesManyBesideContainers) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample>& patched = patched_samples(pool);
  const DecodeBackend draco = draco_backend();
  std::vector<std::unique_ptr<Buffers>> buffers;
  std::vector<PrimitiveLoad> loads;
  std::vector<std::pair<const std::vector<AttributeRequest>*, Mesh>> expected;
  const auto add = [&](const PrimitiveSource& source, const std::vector<AttributeRequest>& requests,
                       const Mesh& mesh) {
    const CompressedPrimitive primitive = must(CompressedPrimitive::open(source));
    buffers.push_back(std::make_unique<Buffers>(requests, primitive.point_count(), primitive.face_count()));
    loads.push_back({primitive, buffers.back()->out});
    expected.emplace_back(&requests, mesh);
  };
  std::vector<uint8_t> broken = smallest(false).bytes;
  broken.resize(broken.size() - 1);
  add({broken, smallest(false).requests, smallest(false).expected.point_count, 0, Compression::kDraco},
      smallest(false).requests, {});
  for (size_t i = 0; i < 60 && i < stream_samples().size(); ++i) {
    add(stream_samples()[i].exact_source(), stream_samples()[i].requests, stream_samples()[i].expected);
    const PatchedSample& sample = patched[i % patched.size()];
    add({sample.encoded.pieces[0].bytes, sample.requests}, sample.requests, sample.mesh);
  }
  for (const DecodeBackend* backend : {static_cast<const DecodeBackend*>(nullptr), &draco}) {
    LoadOptions options{.backend = backend};
    const ThreadPool threads(3);
    options.pool = &threads;
    const std::vector<Status> statuses = decode_primitives(loads, options);
    ASSERT_EQ(statuses.size(), loads.size());
    EXPECT_EQ(statuses[0].code(), StatusCode::kInvalidInput);
    for (size_t i = 1; i < loads.size(); ++i) {
      ASSERT_TRUE(statuses[i].ok()) << statuses[i].to_string();
      EXPECT_TRUE(
          same_bits(buffers[i]->mesh(*expected[i].first, expected[i].second.point_count), expected[i].second));
    }
  }
}

TEST(LoaderOfDracoStreams, RefusesCountsThatAreNotTheStreams) {
  for (const bool is_sequential : {false, true}) {
    const Sample& sample = smallest(is_sequential);
    SCOPED_TRACE(sample.name);
    const uint32_t points = sample.expected.point_count;
    const auto refused = [&](uint64_t point_count, uint64_t index_count) {
      const Expected<CompressedPrimitive> primitive =
          CompressedPrimitive::open(sample.source(point_count, index_count));
      if (!primitive) return primitive.status();
      Buffers buffers(sample.requests, primitive->point_count(), primitive->face_count());
      return primitive->decode(buffers.out);
    };
    EXPECT_TRUE(refused(points, 3 * sample.expected.faces.size()).ok());
    for (const uint64_t count : {points - 1, points + 1, 0xffffffffu}) {
      const Status status = refused(count, 0);
      EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
      EXPECT_TRUE(contains(status.message(), "the stream has "));
    }
    const Status status = refused(points, 3 * sample.expected.faces.size() + 3);
    EXPECT_EQ(status.message(), "the accessors have " + std::to_string(3 * sample.expected.faces.size() + 3) +
                                    " indices, the stream has " +
                                    std::to_string(3 * sample.expected.faces.size()));
  }
}

TEST(LoaderOfDracoStreams, SaysThatOlderBitstreamsAreOlder) {
  Sample sample = smallest(false);
  sample.bytes[5] = 1;  // 1.2
  const Status older = CompressedPrimitive::open(sample.exact_source()).status();
  EXPECT_EQ(older.code(), StatusCode::kUnsupported);
  EXPECT_EQ(
      older.message(),
      "Draco stream: of bitstream 1.2, which is older than 2.2, the only one that is decoded; a build with "
      "the encoder and libdraco decodes older ones");
  sample.bytes[5] = 3;
  const Status newer = decode_draco(sample.bytes).status();
  EXPECT_EQ(newer.code(), StatusCode::kUnsupported);
  EXPECT_TRUE(contains(newer.message(), "bitstream 3.2, which is newer"));
}

TEST(LoaderOfDracoStreams, LibdracoDecodesOlderBitstreams) {
  const std::vector<uint8_t> stream = older_stream();
  PrimitiveSource source{
      stream,
      {{"_ID", 7, ComponentType::kUint16, 1, false}, {"POSITION", 5, ComponentType::kFloat32, 3, false}},
      0,
      0,
      Compression::kDraco};
  EXPECT_EQ(CompressedPrimitive::open(source).status().code(), StatusCode::kUnsupported);
  source.older = older_streams();
  ASSERT_NE(source.older, nullptr);
  const CompressedPrimitive primitive = must(CompressedPrimitive::open(source));
  EXPECT_EQ(primitive.older(), source.older);
  ASSERT_EQ(primitive.point_count(), 4u);
  ASSERT_EQ(primitive.face_count(), 2u);
  EXPECT_EQ(primitive.patch(0).face_count, 2u);
  for (const bool is_patch : {false, true}) {
    Buffers buffers(source.attributes, 4, 2, 2, 3);
    must(is_patch ? primitive.decode_patch(0, buffers.out) : primitive.decode(buffers.out));
    const Mesh mesh = buffers.mesh(source.attributes, 4);
    EXPECT_EQ(mesh.faces[1], (std::array<uint32_t, 3>{2, 1, 3}));
    EXPECT_EQ(std::to_integer<int>(mesh.attributes[0].values[0]), 9);
  }
  std::atomic<bool> stop{true};
  Buffers buffers(source.attributes, 4, 2);
  LoadOptions options;
  options.stop = &stop;
  EXPECT_EQ(primitive.decode(buffers.out, options).code(), StatusCode::kCancelled);
  source.point_count = 5;
  EXPECT_EQ(CompressedPrimitive::open(source).status().message(),
            "the accessors have 5 points, the stream has 4");
  source.point_count = 4;
  source.attributes[0].unique_id = 6;
  const CompressedPrimitive wrong = must(CompressedPrimitive::open(source));
  EXPECT_EQ(wrong.decode(buffers.out).code(), StatusCode::kInvalidInput);
}

TEST(LoaderOfDracoStreams, RefusesEveryTruncationAndContainersInTheirPlace) {
  for (const bool is_sequential : {false, true}) {
    const Sample& sample = smallest(is_sequential);
    for_each_truncation(sample.bytes, [&](const std::vector<uint8_t>& part) {
      const PrimitiveSource source{part, sample.requests, sample.expected.point_count, 0, Compression::kDraco};
      Expected<CompressedPrimitive> primitive = CompressedPrimitive::open(source);
      Status status = primitive.status();
      if (primitive) {
        Buffers buffers(sample.requests, primitive->point_count(), primitive->face_count());
        status = primitive->decode(buffers.out);
      }
      EXPECT_FALSE(status.ok()) << part.size();
      EXPECT_FALSE(status.message().empty());
      EXPECT_FALSE(decode_draco(part)) << part.size();
    });
    EXPECT_FALSE(CompressedPrimitive::open({sample.bytes, sample.requests}));  // as patches
  }
}

TEST(DecodeDraco, IsTheWholeStreamWithNamesThatGltfHas) {
  for (const Sample& sample : stream_samples()) {
    SCOPED_TRACE(sample.name);
    const Mesh mesh = must(decode_draco(sample.bytes));
    EXPECT_TRUE(same_bits(mesh, sample.expected));
    ASSERT_EQ(mesh.attributes.size(), sample.requests.size());
    for (size_t k = 0; k < sample.requests.size(); ++k)
      EXPECT_EQ(mesh.attributes[k].semantic, sample.requests[k].semantic);
  }
}

}  // namespace
}  // namespace psplit
