// psplit::DracoDecoder against draco::Decoder: the same objects, whatever the bytes are.
#include "psplit/draco_decoder.h"

#include <gtest/gtest.h>

#include <sstream>

#include "encoder/libdraco/patch_stream.h"
#include "psplit/parallel.h"
#include "tests/support/corpus_folder.h"
#include "tests/support/corpus_streams.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/draco_streams.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

// All that the public functions of a metadata object tell.
void describe(const draco::Metadata& metadata, std::ostream& out) {
  for (const auto& [name, entry] : metadata.entries())
    out << name << '=' << std::string(entry.data().begin(), entry.data().end()) << ';';
  for (const auto& [name, sub] : metadata.sub_metadatas()) {
    out << name << '{';
    describe(*sub, out);
    out << '}';
  }
}

void write(uint32_t number, std::ostream& out) {
  out.write(reinterpret_cast<const char*>(&number), sizeof number);
}

// All that a geometry has, as text. Values, points of values and faces stand in it byte by byte.
std::string describe(const draco::PointCloud& cloud) {
  std::ostringstream out;
  out << cloud.num_points() << " points\n";
  for (int i = 0; i < cloud.num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *cloud.attribute(i);
    out << "id " << attribute.unique_id() << " role " << attribute.attribute_type() << " type "
        << attribute.data_type() << 'x' << int{attribute.num_components()} << " normalized "
        << attribute.normalized() << " stride " << attribute.byte_stride() << " offset "
        << attribute.byte_offset() << " values " << attribute.size() << " map " << attribute.indices_map_size()
        << '\n';
    for (int n = 0; n < cloud.NumNamedAttributes(attribute.attribute_type()); ++n)
      out << cloud.GetNamedAttributeId(attribute.attribute_type(), n) << ' ';
    if (!attribute.is_mapping_identity())
      for (draco::PointIndex point(0); point < cloud.num_points(); ++point)
        write(attribute.mapped_index(point).value(), out);
    // If libdraco skips the transform of normals, spare bytes of three floats stay after two integers.
    out.write(reinterpret_cast<const char*>(attribute.buffer()->data()),
              static_cast<std::streamsize>(attribute.size()) * attribute.byte_stride());
    if (const draco::AttributeTransformData* transform = attribute.GetAttributeTransformData()) {
      out << " transform " << transform->transform_type();
      const bool is_grid = transform->transform_type() == draco::ATTRIBUTE_QUANTIZATION_TRANSFORM;
      const int words = is_grid ? 2 + attribute.num_components() : 1;
      for (int word = 0; word < words; ++word)
        out << ' ' << transform->GetParameterValue<uint32_t>(static_cast<int>(sizeof(uint32_t)) * word);
    }
  }
  if (cloud.GetMetadata() != nullptr) {
    describe(*cloud.GetMetadata(), out);
    for (const auto& of_attribute : cloud.GetMetadata()->attribute_metadatas()) {
      out << "attribute " << of_attribute->att_unique_id() << ' ';
      describe(*of_attribute, out);
    }
  }
  return out.str();
}
std::string describe(const draco::Mesh& mesh) {
  std::ostringstream out;
  out << describe(static_cast<const draco::PointCloud&>(mesh)) << mesh.num_faces() << " faces ";
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& point : mesh.face(face)) write(point.value(), out);
  for (int i = 0; i < mesh.num_attributes(); ++i) out << mesh.GetAttributeElementType(i) << ' ';
  return out.str();
}

draco::DecoderBuffer buffer_of(const Bytes& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return buffer;
}

template <typename Geometry>
std::string describe(const draco::StatusOr<std::unique_ptr<Geometry>>& result) {
  if (!result.ok()) return std::string("error: ") + result.status().error_msg();
  return describe(*result.value());
}

// Shows where two descriptions begin to differ.
testing::AssertionResult are_equal(const std::string& libdraco, const std::string& ours) {
  const size_t at = static_cast<size_t>(
      std::mismatch(libdraco.begin(), libdraco.end(), ours.begin(), ours.end()).first - libdraco.begin());
  const size_t from = at < 80 ? 0 : at - 80;
  if (libdraco == ours) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "byte " << at << " differs\nlibdraco: "
                                     << testing::PrintToString(libdraco.substr(from, 200))
                                     << "\nours:     " << testing::PrintToString(ours.substr(from, 200));
}

enum class Transforms { kApplied, kSkipped };

template <typename Decoder>
std::string decode(const Bytes& bytes, bool as_mesh, Transforms transforms) {
  Decoder decoder;
  if (transforms == Transforms::kSkipped)
    for (int type = 0; type < draco::GeometryAttribute::NAMED_ATTRIBUTES_COUNT; ++type)
      decoder.SetSkipAttributeTransform(static_cast<draco::GeometryAttribute::Type>(type));
  draco::DecoderBuffer buffer = buffer_of(bytes);
  return as_mesh ? describe(decoder.DecodeMeshFromBuffer(&buffer))
                 : describe(decoder.DecodePointCloudFromBuffer(&buffer));
}

// A libdraco that fuses has the same integers, and makes other floats of some.
constexpr Transforms kComparable = kLibdracoFuses ? Transforms::kSkipped : Transforms::kApplied;

void expect_equal(const Bytes& bytes, bool as_mesh) {
  for (const Transforms transforms : {kComparable, Transforms::kSkipped})
    EXPECT_TRUE(are_equal(decode<draco::Decoder>(bytes, as_mesh, transforms),
                          decode<DracoDecoder>(bytes, as_mesh, transforms)));
}

// Whether psplit decodes this, and does not leave it to libdraco.
bool is_ours(const Bytes& bytes) {
  draco::DecoderBuffer buffer = buffer_of(bytes);
  draco::Mesh mesh;
  if (decode_into(mesh, buffer)) return true;
  draco::PointCloud cloud;
  return decode_into(cloud, buffer);
}

TEST(DracoDecoder, FillsMeshesAsLibdracoDoes) {
  for (const DracoStream& stream : small_draco_streams()) {
    SCOPED_TRACE(stream.name);
    expect_equal(stream.bytes, true);
    EXPECT_TRUE(is_ours(stream.bytes));
  }
}

TEST(DracoDecoder, FillsPointCloudsAsLibdracoDoes) {
  for (const DracoStream& stream : small_draco_clouds()) {
    SCOPED_TRACE(stream.name);
    expect_equal(stream.bytes, false);
    EXPECT_TRUE(is_ours(stream.bytes));
  }
}

TEST(DracoDecoder, GivesAMeshWhereAPointCloudIsAskedFor) {
  const Bytes& bytes = small_draco_streams()[0].bytes;
  expect_equal(bytes, false);
  draco::DecoderBuffer buffer = buffer_of(bytes);
  auto decoded = DracoDecoder().DecodePointCloudFromBuffer(&buffer);
  ASSERT_TRUE(decoded.ok());
  EXPECT_NE(dynamic_cast<draco::Mesh*>(decoded.value().get()), nullptr);
  EXPECT_EQ(buffer.remaining_size(), 0);
  // The other way round, libdraco refuses.
  expect_equal(small_draco_clouds()[0].bytes, true);
}

// Each role's transform alone.
TEST(DracoDecoder, SkipsTheTransformsThatItIsTold) {
  if (kLibdracoFuses) GTEST_SKIP() << "this libdraco fuses multiply-adds";
  for (const DracoStream& stream : small_draco_streams()) {
    if (stream.bytes.size() > 3000) continue;
    SCOPED_TRACE(stream.name);
    for (int type = 0; type < draco::GeometryAttribute::NAMED_ATTRIBUTES_COUNT; ++type) {
      const auto decode_with = [&](auto decoder) {
        decoder.SetSkipAttributeTransform(static_cast<draco::GeometryAttribute::Type>(type));
        draco::DecoderBuffer buffer = buffer_of(stream.bytes);
        return describe(decoder.DecodeMeshFromBuffer(&buffer));
      };
      EXPECT_TRUE(are_equal(decode_with(draco::Decoder()), decode_with(DracoDecoder()))) << "role " << type;
    }
  }
}

TEST(DracoDecoder, LeavesWhatDoesNotDecodeToLibdraco) {
  size_t count = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    constexpr size_t kEvery = 8;
    if (stream.bytes.size() > 600 || count++ % kEvery > 0) continue;
    SCOPED_TRACE(stream.name);
    for (size_t size = 0; size < stream.bytes.size(); size += 7)
      expect_equal(Bytes(stream.bytes.begin(), stream.bytes.begin() + static_cast<std::ptrdiff_t>(size)), true);
    Bytes changed = stream.bytes;
    for (size_t i = 0; i < changed.size(); i += 5) {
      const uint8_t before = changed[i];
      changed[i] ^= 0x15;
      // libdraco accepts some broken streams, and gives unused values that nobody set.
      const bool ours = is_ours(changed);
      if (!ours || decode<draco::Decoder>(changed, true, Transforms::kApplied).rfind("error", 0) == 0) {
        EXPECT_TRUE(are_equal(decode<draco::Decoder>(changed, true, Transforms::kApplied),
                              decode<DracoDecoder>(changed, true, Transforms::kApplied)));
      }
      changed[i] = before;
    }
  }
}

TEST(DracoDecoder, LeavesGeometriesThatHaveSomethingAsTheyAre) {
  const Bytes& bytes = small_draco_streams()[0].bytes;
  draco::DecoderBuffer buffer = buffer_of(bytes);
  draco::Mesh mesh;
  ASSERT_TRUE(decode_into(mesh, buffer));
  const std::string before = describe(mesh);
  buffer = buffer_of(bytes);
  EXPECT_FALSE(decode_into(mesh, buffer));
  EXPECT_EQ(describe(mesh), before);
  EXPECT_EQ(buffer.remaining_size(), static_cast<int64_t>(bytes.size()));
}

TEST(DracoDecoder, DecodesOnSeveralThreads) {
  const std::vector<DracoStream>& streams = small_draco_streams();
  std::vector<std::string> results(streams.size());
  ThreadPool(4).for_each(streams.size(), [&](size_t i) {
    results[i] = decode<DracoDecoder>(streams[i].bytes, true, kComparable);
  });
  for (size_t i = 0; i < streams.size(); ++i)
    EXPECT_TRUE(are_equal(decode<draco::Decoder>(streams[i].bytes, true, kComparable), results[i]))
        << streams[i].name;
}

TEST(DracoDecoder, FillsTheMeshesOfTheCorpus) {
  size_t count = 0;
  for_each_corpus_stream([&](const std::string& file, const Bytes& stream) {
    SCOPED_TRACE(file);
    expect_equal(stream, true);
    ++count;
  });
  if (count == 0) GTEST_SKIP() << "no corpus at " << corpus_folder();
}

}  // namespace
}  // namespace psplit
