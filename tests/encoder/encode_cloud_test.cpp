// Point clouds through the door of the encoder (psplit/encode.h): verified, in an order that is told.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/mesh/number_of.h"
#include "tests/support/expect.h"

namespace psplit {
namespace {

const ThreadPool kPool(1);

template <typename T>
void add_values(Mesh& cloud, const std::string& semantic, ComponentType type, uint8_t components,
                std::span<const T> values) {
  Attribute& attribute = cloud.attributes.emplace_back(Attribute{semantic, type, components, false, {}});
  const auto bytes = std::as_bytes(values);
  attribute.values.assign(bytes.begin(), bytes.end());
}

// Positions, unit normals and colours. Points 0 and 1 are equal.
Mesh a_cloud(uint32_t point_count) {
  std::mt19937 random(point_count);
  const auto unit = [&] { return static_cast<float>(random() % 20001) / 10000.0f - 1; };
  std::vector<float> positions, normals;
  std::vector<uint8_t> colors;
  for (uint32_t i = 0; i < point_count; ++i) {
    const float x = unit(), y = unit(), z = 2 + unit(), length = std::sqrt(x * x + y * y + z * z);
    for (const float value : {3 * x, 2 * y, z}) positions.push_back(value);
    for (const float value : {x, y, z}) normals.push_back(value / length);
    for (int k = 0; k < 4; ++k) colors.push_back(static_cast<uint8_t>(random()));
  }
  if (point_count > 1) {
    std::copy_n(positions.begin(), 3, positions.begin() + 3);
    std::copy_n(normals.begin(), 3, normals.begin() + 3);
    std::copy_n(colors.begin(), 4, colors.begin() + 4);
  }
  Mesh cloud{point_count, {}, {}};
  add_values<float>(cloud, "POSITION", ComponentType::kFloat32, 3, positions);
  add_values<float>(cloud, "NORMAL", ComponentType::kFloat32, 3, normals);
  add_values<uint8_t>(cloud, "COLOR_0", ComponentType::kUint8, 4, colors);
  cloud.attributes[2].normalized = true;
  return cloud;
}

EncodeOptions cloud_options(int speed = 5) {
  EncodeOptions options;
  options.storage = Storage::kCloud;
  options.encode_speed = speed;
  return options;
}

TEST(EncodeCloud, EveryPointComesBackWhereItIsSaidToBe) {
  for (const uint32_t count : {1u, 2u, 3u, 100u, 5000u})
    for (int speed = 0; speed <= 10; ++speed)
      for (const bool lossless : {false, true}) {
        SCOPED_TRACE(std::to_string(count) + " points, speed " + std::to_string(speed));
        const Mesh cloud = a_cloud(count);
        EncodeOptions options = cloud_options(speed);
        options.lossless = lossless;
        const EncodedMesh encoded = must(encode(cloud, options, kPool));
        ASSERT_EQ(encoded.pieces.size(), 1u);
        const EncodedPiece& piece = encoded.pieces[0];
        EXPECT_FALSE(piece.is_container);
        EXPECT_TRUE(encoded.statistics.position_error);
        StreamDescription description;
        const Mesh decoded = must(decode_draco(piece.bytes, &description));
        EXPECT_EQ(description.coding,
                  speed == 10 || lossless ? StreamCoding::kCloudSequential : StreamCoding::kCloudKdTree);
        ASSERT_EQ(decoded.point_count, count);
        ASSERT_EQ(piece.source_point.size(), count);
        std::vector<uint8_t> seen(count);
        for (uint32_t point = 0; point < count; ++point) ++seen[piece.source_point[point]];
        EXPECT_EQ(std::ranges::count(seen, 1), count);
        for (const Attribute& attribute : cloud.attributes) {
          const Attribute* const found = decoded.find(attribute.semantic);
          ASSERT_NE(found, nullptr) << attribute.semantic;
          EXPECT_EQ(found->normalized, attribute.normalized);
          const bool is_exact = lossless || attribute.component_type != ComponentType::kFloat32;
          const double bound = is_exact ? 0 : attribute.semantic == "NORMAL" ? 5e-3 : 5e-4;
          for (size_t at = 0; at < size_t{count} * attribute.component_count; ++at) {
            const size_t point = at / attribute.component_count, k = at % attribute.component_count;
            const size_t from = piece.source_point[point] * size_t{attribute.component_count} + k;
            if (attribute.component_type == ComponentType::kFloat32)
              ASSERT_NEAR(float_at(*found, at), float_at(attribute, from), bound) << attribute.semantic;
            else
              ASSERT_EQ(found->values[at], attribute.values[from]) << attribute.semantic;
          }
        }
      }
}

// Each error names the fault.
TEST(EncodeCloud, RefusesWhatIsNoCloud) {
  const auto fails = [](StatusCode code, Mesh cloud, const EncodeOptions& options, const std::string& text) {
    const Status status = encode(std::move(cloud), options, kPool).status();
    EXPECT_EQ(status.code(), code) << status.message();
    EXPECT_NE(status.message().find(text), std::string::npos) << status.message();
  };
  Mesh with_faces = a_cloud(3);
  with_faces.faces.push_back({0, 1, 2});
  fails(StatusCode::kInvalidInput, with_faces, cloud_options(), "no faces");
  fails(StatusCode::kInvalidInput, a_cloud(0), cloud_options(), "no points");
  fails(StatusCode::kInvalidInput, a_cloud(3), {}, "no triangles");
  Mesh without_positions = a_cloud(3);
  without_positions.attributes.erase(without_positions.attributes.begin());
  fails(StatusCode::kInvalidInput, without_positions, cloud_options(), "no POSITION");
  Mesh too_few = a_cloud(3);
  too_few.attributes[1].values.resize(12);
  fails(StatusCode::kInvalidInput, too_few, cloud_options(), "another number of points");
  fails(StatusCode::kUsage, a_cloud(3), cloud_options(11), "encode speed 11");
  EncodeOptions by_edges = cloud_options();
  by_edges.position_bits_by_edges = true;
  fails(StatusCode::kUsage, a_cloud(3), by_edges, "no edges");
  EncodeOptions libdraco = cloud_options();
  libdraco.by_libdraco = true;
  fails(StatusCode::kUnsupported, a_cloud(3), libdraco, "not for point clouds");
}

// Draco's sequential streams have sums of 32 bits, trees have not.
TEST(EncodeCloud, LargeIntegersNeedATree) {
  const std::vector<uint32_t> numbers = {0, 0x7fffffff, 3, 0x40000000};
  for (const uint32_t most : {0xffffffffu, 0x7fffffffu, 0x3fffffffu}) {
    Mesh cloud = a_cloud(4);
    std::vector<uint32_t> values = numbers;
    for (uint32_t& value : values) value = std::min(value, most);
    values[1] = most;
    add_values<uint32_t>(cloud, "_NUMBER", ComponentType::kUint32, 1, values);
    const EncodedMesh encoded = must(encode(cloud, cloud_options(5), kPool));
    EXPECT_EQ(must(describe_stream(encoded.pieces[0].bytes)).coding, StreamCoding::kCloudKdTree);
    const Status sequential = encode(cloud, cloud_options(10), kPool).status();
    EXPECT_EQ(sequential.code(), most > 0x3fffffff ? StatusCode::kUnsupported : StatusCode::kOk)
        << sequential.message();
  }
}

// No grid has such values, so they are kept exactly, as in meshes.
TEST(EncodeCloud, ValuesWithoutAGridAreExactAndNoted) {
  Mesh cloud = a_cloud(50);
  const float infinity = INFINITY;
  std::memcpy(cloud.attributes[1].values.data(), &infinity, sizeof infinity);
  const EncodedMesh encoded = must(encode(cloud, cloud_options(), kPool));
  EXPECT_EQ(encoded.codings[1].bits, 0);
  ASSERT_FALSE(encoded.notes.empty());
  EXPECT_NE(encoded.notes[0].text.find("NORMAL is kept exactly"), std::string::npos) << encoded.notes[0].text;
  EXPECT_EQ(must(describe_stream(encoded.pieces[0].bytes)).coding, StreamCoding::kCloudSequential);
}

// The coarsest grid that keeps the error.
TEST(EncodeCloud, BitsFollowFromAnError) {
  EncodeOptions options = cloud_options();
  options.max_position_error = 0.01;
  const EncodedMesh encoded = must(encode(a_cloud(1000), options, kPool));
  EXPECT_LE(*encoded.statistics.position_error, 0.01);
  EXPECT_LT(encoded.codings[0].bits, 14);
}

}  // namespace
}  // namespace psplit
