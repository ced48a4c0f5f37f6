// Whole streams in their own terms, against libdraco.
#include <set>

#include "psplit/decode.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

TEST(DecodeGeometry, GivesEachAttributeInItsOwnType) {
  std::set<DataType> types;
  for_each_draco_cloud([&](const DracoStream& stream) {
    SCOPED_TRACE(stream.name);
    const RawMesh expected = must(decode_cloud_with_libdraco(stream.bytes));
    const DracoGeometry cloud = must(decode_geometry(stream.bytes));
    constexpr size_t kMethod = 8;
    EXPECT_EQ(cloud.coding,
              stream.bytes[kMethod] == 0 ? StreamCoding::kCloudSequential : StreamCoding::kCloudKdTree);
    EXPECT_EQ(cloud.point_count, expected.point_count);
    ASSERT_EQ(cloud.attributes.size(), expected.attributes.size());
    for (size_t i = 0; i < expected.attributes.size(); ++i) {
      const RawAttribute& raw = expected.attributes[i];
      const GeometryAttribute& attribute = cloud.attributes[i];
      EXPECT_EQ(attribute.description.unique_id, raw.unique_id);
      EXPECT_EQ(static_cast<int>(attribute.description.semantic), raw.type);
      EXPECT_EQ(static_cast<int>(attribute.description.type), raw.data_type);
      EXPECT_EQ(attribute.description.components, raw.component_count);
      EXPECT_EQ(attribute.description.normalized, raw.normalized);
      const auto* values = reinterpret_cast<const uint8_t*>(attribute.values.data());
      EXPECT_TRUE(std::equal(values, values + attribute.values.size(), raw.point_values.begin(),
                             raw.point_values.end()));
      types.insert(attribute.description.type);
    }
  });
  EXPECT_EQ(types.size(), 11u);
}

// A cloud that glTF can hold: positions, and numbers of components that it has.
const DracoStream& usual_cloud() {
  for (const DracoStream& stream : small_draco_clouds())
    if (stream.name.starts_with("positions, normals and colours of 64:") &&
        stream.name.find("kD-tree") != std::string::npos)
      return stream;
  throw std::runtime_error("no such cloud");
}

TEST(DecodeGeometry, OfACloudAgreesWithItsMeshWithoutFaces) {
  StreamDescription description;
  const Mesh mesh = must(decode_draco(usual_cloud().bytes, &description));
  EXPECT_TRUE(description == must(describe_stream(usual_cloud().bytes)));
  EXPECT_EQ(description.coding, StreamCoding::kCloudKdTree);
  EXPECT_TRUE(is_cloud(description.coding));
  EXPECT_STREQ(coding_name(description.coding), "cloud-kd-tree");
  EXPECT_EQ(description.face_count, 0u);
  EXPECT_EQ(mesh.point_count, 64u);
  EXPECT_TRUE(mesh.faces.empty());
  // Values have the bits that they have in their own types.
  const DracoGeometry cloud = must(decode_geometry(usual_cloud().bytes));
  ASSERT_EQ(mesh.attributes.size(), 3u);
  const char* const semantics[] = {"POSITION", "NORMAL", "COLOR_0"};
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    EXPECT_EQ(mesh.attributes[i].semantic, semantics[i]);
    EXPECT_EQ(mesh.attributes[i].values, cloud.attributes[i].values);
  }
  EXPECT_TRUE(mesh.attributes[2].normalized);
}

TEST(DecodeGeometry, SaysHowValuesAreStored) {
  const StreamDescription description = must(describe_stream(usual_cloud().bytes));
  EXPECT_EQ(description.attributes[0].bits, 14);
  EXPECT_GT(description.attributes[0].range, 0);
  EXPECT_EQ(description.attributes[0].origin.size(), 3u);
  EXPECT_EQ(description.attributes[2].bits, 0);
}

TEST(DecodeGeometry, SaysWhatItRefuses) {
  std::vector<uint8_t> bytes = usual_cloud().bytes;
  bytes[6] = 1;
  for (const Status& status : {decode_geometry(bytes).status(), describe_stream(bytes).status()}) {
    EXPECT_EQ(status.code(), StatusCode::kUnsupported);
    EXPECT_EQ(status.message(),
              "Draco stream: a point cloud of bitstream 2.1, and only 2.2 and 2.3 are decoded");
  }
  bytes = usual_cloud().bytes;
  bytes[14] = 1;  // more points than the tree has
  EXPECT_EQ(decode_geometry(bytes).status().code(), StatusCode::kInvalidInput);
  bytes.resize(bytes.size() / 2);
  EXPECT_EQ(describe_stream(bytes).status().code(), StatusCode::kInvalidInput);
}

}  // namespace
}  // namespace psplit
