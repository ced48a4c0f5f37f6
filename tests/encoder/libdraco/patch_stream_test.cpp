#include "encoder/libdraco/patch_stream.h"

#include <cstring>
#include <map>

#include "encoder/libdraco/draco_backend.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/welding/weld.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

// A sheet of size x size quads whose texture coordinates jump along every `seam_every`-th column, and at single
// edges scattered over it, so that seams end inside, cross and meet.
Mesh sheet(uint32_t size, uint32_t seam_every) {
  Mesh mesh;
  std::vector<float> positions, texcoords;
  std::vector<uint16_t> ids;
  const auto point = [&](uint32_t x, uint32_t y, uint32_t chart) {
    for (float value : {float(x), float(y), float((x * 7 + y * 13) % 5)}) positions.push_back(value);
    for (float value : {float(x) + 100 * float(chart), float(y)}) texcoords.push_back(value);
    ids.push_back(static_cast<uint16_t>((x / 3 + y / 4) % 2));
    return mesh.point_count++;
  };
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const uint32_t chart = seam_every == 0 ? 0 : x / seam_every + ((x * 31 + y * 17) % 11 == 0 ? 50 : 0);
      const uint32_t a = point(x, y, chart), b = point(x + 1, y, chart), c = point(x, y + 1, chart),
                     d = point(x + 1, y + 1, chart);
      mesh.faces.push_back({a, b, d});
      mesh.faces.push_back({a, d, c});
    }
  const auto attribute = [&](const char* semantic, ComponentType type, uint8_t components, const void* data,
                             size_t bytes) {
    Attribute& added = mesh.attributes.emplace_back(Attribute{semantic, type, components, false, {}});
    added.values.resize(bytes);
    std::memcpy(added.values.data(), data, bytes);
  };
  attribute("TEXCOORD_0", ComponentType::kFloat32, 2, texcoords.data(), texcoords.size() * 4);
  attribute("POSITION", ComponentType::kFloat32, 3, positions.data(), positions.size() * 4);
  attribute("_FEATURE_ID_0", ComponentType::kUint16, 1, ids.data(), ids.size() * 2);

  // Merge the corners that are the same point.
  const std::vector<uint32_t> lowest = find_duplicates(mesh, {}, 0, ThreadPool(1));
  for (auto& face : mesh.faces)
    for (uint32_t& p : face) p = lowest[p];
  return mesh;
}

PatchMesh whole(const Mesh& mesh) {
  PatchMesh patch;
  std::vector<uint32_t> number(mesh.point_count, 0xffffffffu);
  for (const auto& face : mesh.faces) {
    auto& local = patch.faces.emplace_back(face);
    for (uint32_t& p : local) {
      if (number[p] == 0xffffffffu) {
        number[p] = static_cast<uint32_t>(patch.points.size());
        patch.points.push_back(p);
      }
      p = number[p];
    }
  }
  return patch;
}

class PatchStream : public testing::TestWithParam<std::tuple<int, uint32_t>> {};

TEST_P(PatchStream, NamesThePointsOfTheStream) {
  const auto [speed, seam_every] = GetParam();
  const Mesh mesh = sheet(24, seam_every);
  const WeldedMesh welded = weld(mesh, ThreadPool(1));
  const PatchMesh patch = whole(mesh);
  const std::vector<AttributeCoding> codings = {{12, false, {0, 0}, 8000}, {14, false, {0, 0, 0}, 32}, {}};

  const auto encoded = must(encode_edgebreaker(welded, patch, codings, speed, true));
  const std::vector<uint32_t>& patch_point = encoded.patch_point;

  const std::vector<AttributeRequest> requests = stream_requests(mesh);
  EXPECT_EQ(requests[0].unique_id, 1u);
  EXPECT_EQ(requests[1].unique_id, 0u);
  EXPECT_EQ(requests[2].unique_id, 2u);
  const auto decoded = must(decode_draco_stream(encoded.bytes, requests));
  EXPECT_EQ(decoded.faces, encoded.decoded.faces);
  ASSERT_EQ(decoded.point_count, patch_point.size());
  for (size_t i = 0; i < requests.size(); ++i) {
    EXPECT_EQ(decoded.attributes[i].semantic, encoded.decoded.attributes[i].semantic);
    EXPECT_EQ(decoded.attributes[i].values, encoded.decoded.attributes[i].values);
  }
  for (uint32_t i = 0; i < decoded.point_count; ++i) {
    const uint32_t source = patch.points[patch_point[i]];
    uint16_t got = 0, wanted = 0;
    std::memcpy(&got, decoded.attributes[2].values.data() + i * 2, 2);
    std::memcpy(&wanted, mesh.attributes[2].values.data() + source * 2, 2);
    EXPECT_EQ(got, wanted);
    for (size_t c = 0; c < 3; ++c) {
      float got_position = 0, wanted_position = 0;
      std::memcpy(&got_position, decoded.attributes[1].values.data() + i * 12 + c * 4, 4);
      std::memcpy(&wanted_position, mesh.attributes[1].values.data() + source * 12 + c * 4, 4);
      EXPECT_NEAR(got_position, wanted_position, 0.5 * 32 / 16383 + 1e-4);
    }
  }
  const auto description = must(describe_draco_stream(encoded.bytes));
  EXPECT_EQ(description.face_count, encoded.decoded.faces.size());
  EXPECT_EQ(description.point_count, patch_point.size());
  std::map<uint32_t, int> bits;
  for (const StreamAttribute& attribute : description.attributes) bits[attribute.unique_id] = attribute.bits;
  EXPECT_EQ(bits, (std::map<uint32_t, int>{
                      {requests[0].unique_id, 12}, {requests[1].unique_id, 14}, {requests[2].unique_id, 0}}));
}

INSTANTIATE_TEST_SUITE_P(SpeedsAndSeams, PatchStream,
                         testing::Combine(testing::Values(0, 1, 3, 5, 6, 7, 10),
                                          testing::Values(0u, 1u, 3u, 8u)));

TEST(PatchStreamErrors, GarbageIsRefused) {
  const std::vector<uint8_t> garbage(100, 0x5a);
  EXPECT_EQ(decode_draco_stream(garbage, {}).status().code(), StatusCode::kInvalidInput);
  EXPECT_EQ(describe_draco_stream(std::vector<uint8_t>{}).status().code(), StatusCode::kInvalidInput);
}

// One triangle whose grids begin at 0 and have the range 1.
uint64_t table_bytes(const std::vector<float>& positions, const AttributeCoding& of_positions, int texture_bits,
                     int speed) {
  Mesh mesh = make_mesh(positions, {{0, 1, 2}});
  mesh.attributes.push_back(float_attribute("TEXCOORD_0", 2, {0, 0, 1, 0, 1, 1}));
  const WeldedMesh welded = weld(mesh, ThreadPool(1));
  const std::vector<AttributeCoding> codings = {of_positions, {texture_bits, false, {0, 0}, 1}};
  return symbol_table_bytes(welded, {{0, 1, 2}, {{0, 1, 2}}, {}}, codings, speed);
}

TEST(SymbolTable, IsAsLargeAsThePatchIsWide) {
  const std::vector<float> wide = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                           narrow = {0.5f, 0, 0, 0.501f, 0.001f, 0, 0.5f, 0, 0};
  const auto bytes = [](const std::vector<float>& positions, int bits, int texture_bits, int speed = 5) {
    return table_bytes(positions, {bits, false, {0, 0, 0}, 1}, texture_bits, speed);
  };
  EXPECT_EQ(bytes(wide, 24, 24), 0u);
  EXPECT_EQ(bytes(wide, 21, 21, 0), 0u);
  EXPECT_NEAR(static_cast<double>(bytes(wide, 24, 12, 1)), 32.0 * (1 << 24), 1000);
  EXPECT_NEAR(static_cast<double>(bytes(wide, 28, 12)), 4.0 * (1 << 28), 100);
  EXPECT_NEAR(static_cast<double>(bytes(wide, 14, 26)), 4.0 * (1 << 26), 100);
  // All components count together: the first one is near the middle of the grid, and the last one is 0.
  EXPECT_NEAR(static_cast<double>(bytes(narrow, 28, 12)), 4.0 * 0.501 * (1 << 28), 1000);
  EXPECT_EQ(table_bytes(narrow, {28, true, {}, 0}, 0, 2), uint64_t{4} << 28);
}

}  // namespace
}  // namespace psplit
