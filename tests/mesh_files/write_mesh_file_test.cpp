// Mesh files that psplit writes hold the same bits when psplit reads them.
#include "mesh_files/write_mesh_file.h"

#include <bit>
#include <random>

#include "mesh_files/obj.h"
#include "mesh_files/ply.h"
#include "mesh_files/stl.h"
#include "tests/mesh_files/mesh_text.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

template <typename T>
Attribute attribute_of(const char* semantic, int components, const std::vector<T>& values, ComponentType type,
                       bool normalized = false) {
  Attribute attribute{semantic, type, static_cast<uint8_t>(components), normalized, {}};
  attribute.values.resize(values.size() * sizeof(T));
  std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  return attribute;
}

// A fan of points whose floats have all bits, of all exponents that positions have in practice.
Mesh random_mesh(uint32_t points, unsigned seed) {
  std::mt19937 random(seed);
  const auto floats = [&](size_t count, int exponents) {
    std::vector<float> values(count);
    for (float& value : values)
      value = std::ldexp(static_cast<float>(random() >> 8),
                         static_cast<int>(random() % static_cast<unsigned>(exponents)) - 24 - exponents / 2) *
              (random() % 2 == 0 ? 1.0f : -1.0f);
    return values;
  };
  Mesh mesh;
  mesh.point_count = points;
  mesh.attributes.push_back(attribute_of("POSITION", 3, floats(3 * points, 60), ComponentType::kFloat32));
  mesh.attributes.push_back(attribute_of("NORMAL", 3, floats(3 * points, 4), ComponentType::kFloat32));
  std::vector<float> texcoords(2 * points);
  for (float& value : texcoords) value = static_cast<float>(random()) / 4294967296.0f;
  mesh.attributes.push_back(attribute_of("TEXCOORD_0", 2, texcoords, ComponentType::kFloat32));
  std::vector<uint8_t> colors(3 * points);
  for (uint8_t& value : colors) value = static_cast<uint8_t>(random());
  mesh.attributes.push_back(attribute_of("COLOR_0", 3, colors, ComponentType::kUint8, true));
  mesh.attributes.push_back(attribute_of("_QUALITY", 1, floats(points, 20), ComponentType::kFloat32));
  for (uint32_t i = 0; i + 2 < points; ++i) mesh.faces.push_back({i, i + 1, i + 2});
  return mesh;
}

PlacedPart part_of(const Mesh& mesh, const std::string& object = "", const std::string& material = "") {
  return {object, material, view_of(mesh)};
}

class WrittenMeshFile : public testing::Test {
 protected:
  template <typename Read>
  MeshFile written(AssetFormat format, const std::vector<PlacedPart>& parts, const Read& read) {
    must(write_mesh_file(folder_ / "file", format, parts));
    Expected<Scanner> scanner = open_scanner(std::move(*open_byte_stream(folder_ / "file")));
    MeshFile file = must(read(*scanner));
    settle_positions(file, {});
    return file;
  }
  MeshFile ply(const std::vector<PlacedPart>& parts) {
    return written(AssetFormat::kPly, parts, [](Scanner& scanner) { return read_ply(scanner, ThreadPool(1)); });
  }
  MeshFile obj(const std::vector<PlacedPart>& parts) {
    return written(AssetFormat::kObj, parts, [](Scanner& scanner) {
      return read_obj(scanner, [](const std::string&) -> Expected<std::unique_ptr<ByteStream>> {
        return io_failure("no library");
      });
    });
  }
  MeshFile stl(const std::vector<PlacedPart>& parts) {
    return written(AssetFormat::kStl, parts, [](Scanner& scanner) { return read_stl(scanner, {}); });
  }

  TestFolder folder_;
};

TEST_F(WrittenMeshFile, PlyHoldsTheSameBits) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Mesh mesh = random_mesh(500, seed);
    const MeshFile file = ply({part_of(mesh)});
    const Mesh& back = file.objects.at(0).parts.at(0).mesh;
    EXPECT_EQ(back.point_count, mesh.point_count);
    EXPECT_EQ(back.faces, mesh.faces);
    for (const Attribute& attribute : mesh.attributes) {
      const Attribute* const found = back.find(attribute.semantic);
      ASSERT_NE(found, nullptr) << attribute.semantic;
      EXPECT_EQ(found->component_type, attribute.component_type);
      EXPECT_EQ(found->normalized, attribute.normalized);
      if (attribute.semantic == "TEXCOORD_0") continue;
      EXPECT_EQ(found->values, attribute.values) << attribute.semantic;
    }
    // PLY counts v from the bottom: it is rounded to a float once.
    const std::vector<float> before = floats_of(mesh, "TEXCOORD_0"), after = floats_of(back, "TEXCOORD_0");
    for (size_t i = 0; i < before.size(); ++i)
      EXPECT_NEAR(after[i], before[i], i % 2 == 0 ? 0 : std::ldexp(1.0, -25)) << i;
  }
}

TEST_F(WrittenMeshFile, ObjHoldsTheSameBits) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Mesh mesh = random_mesh(500, seed);
    const MeshFile file = obj({part_of(mesh)});
    EXPECT_EQ(file.objects.at(0).name, "");
    const Mesh& back = file.objects.at(0).parts.at(0).mesh;
    EXPECT_EQ(back.faces, mesh.faces);
    for (const char* semantic : {"POSITION", "NORMAL", "TEXCOORD_0"})
      EXPECT_EQ(back.find(semantic)->values, mesh.find(semantic)->values) << semantic;
    const std::vector<float> colors = floats_of(back, "COLOR_0");
    ASSERT_EQ(colors.size(), mesh.find("COLOR_0")->values.size());
    for (size_t i = 0; i < colors.size(); ++i)
      EXPECT_EQ(colors[i], static_cast<float>(std::to_integer<int>(mesh.find("COLOR_0")->values[i]) / 255.0));
  }
}

TEST_F(WrittenMeshFile, StlHoldsTheSamePositions) {
  const Mesh mesh = random_mesh(300, 1);
  const MeshFile file = stl({part_of(mesh)});
  const Mesh& back = file.objects.at(0).parts.at(0).mesh;
  const std::vector<float> before = floats_of(mesh, "POSITION"), after = floats_of(back, "POSITION");
  ASSERT_EQ(back.faces.size(), mesh.faces.size());
  for (size_t face = 0; face < mesh.faces.size(); ++face)
    for (size_t corner = 0; corner < 3; ++corner)
      for (size_t axis = 0; axis < 3; ++axis)
        EXPECT_EQ(std::bit_cast<uint32_t>(after[3 * back.faces[face][corner] + axis]),
                  std::bit_cast<uint32_t>(before[3 * mesh.faces[face][corner] + axis]));
}

TEST_F(WrittenMeshFile, PartsFollowOneAnother) {
  const Mesh a = random_mesh(4, 1), b = random_mesh(5, 2);
  Mesh bare = random_mesh(3, 3);
  bare.attributes.resize(1);
  const std::vector<PlacedPart> parts = {part_of(a, "one"), part_of(b, "two"), part_of(bare, "two", "red")};
  EXPECT_EQ(attributes_left_out(AssetFormat::kPly, parts),
            (std::set<std::string>{"COLOR_0", "NORMAL", "TEXCOORD_0", "_QUALITY"}));
  EXPECT_EQ(attributes_left_out(AssetFormat::kObj, parts), (std::set<std::string>{"COLOR_0", "_QUALITY"}));
  EXPECT_EQ(attributes_left_out(AssetFormat::kStl, {parts.data(), 1}),
            (std::set<std::string>{"COLOR_0", "NORMAL", "TEXCOORD_0", "_QUALITY"}));
  const MeshFile objects = obj(parts);
  ASSERT_EQ(objects.objects.size(), 3u);  // the first has no faces
  EXPECT_EQ(objects.objects[1].name, "one");
  ASSERT_EQ(objects.objects[2].parts.size(), 2u);
  EXPECT_EQ(objects.objects[2].parts[0].mesh.find("NORMAL")->values, b.find("NORMAL")->values);
  EXPECT_EQ(objects.objects[2].parts[1].mesh.find("POSITION")->values, bare.find("POSITION")->values);
  EXPECT_EQ(objects.objects[2].parts[1].mesh.find("NORMAL"), nullptr);
  EXPECT_GE(objects.objects[2].parts[1].material, 0);
  const MeshFile one = ply(parts);
  const Mesh& mesh = one.objects.at(0).parts.at(0).mesh;
  EXPECT_EQ(mesh.point_count, 12u);
  EXPECT_EQ(mesh.faces.at(5), (std::array<uint32_t, 3>{9, 10, 11}));
  EXPECT_EQ(mesh.find("NORMAL"), nullptr);
}

TEST_F(WrittenMeshFile, PartsAreWrittenAtTheirPlace) {
  const Mesh mesh = random_mesh(3, 1);
  PlacedPart part = part_of(mesh);
  part.mirrored = true;
  part.place = [](std::string_view semantic, std::span<double> value) {
    if (semantic == "POSITION") value[0] = -value[0];
  };
  for (const MeshFile& file : {ply({part}), obj({part})}) {
    const Mesh& back = file.objects.at(0).parts.at(0).mesh;
    const std::vector<float> before = floats_of(mesh, "POSITION"), after = floats_of(back, "POSITION");
    const uint32_t second = back.faces.at(0)[1];
    EXPECT_EQ(after[3 * second], -before[6]);
    EXPECT_EQ(after[3 * second + 1], before[7]);
  }
}

TEST_F(WrittenMeshFile, PositionsMustBeFinite) {
  Mesh mesh = random_mesh(3, 1);
  const float infinite = HUGE_VALF;
  std::memcpy(mesh.attributes[0].values.data(), &infinite, sizeof infinite);
  const std::vector<PlacedPart> parts = {part_of(mesh)};
  for (const AssetFormat format : {AssetFormat::kPly, AssetFormat::kObj, AssetFormat::kStl}) {
    const Status status = write_mesh_file(folder_ / "file", format, parts);
    EXPECT_EQ(status.code(), StatusCode::kUnsupported);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "file"));
  }
}

}  // namespace
}  // namespace psplit
