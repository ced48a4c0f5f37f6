// Draco files of points: decode makes them a glTF of points, inspect and validate tell of them, and all other
// commands refuse them.
#include <cmath>
#include <cstring>

#include "gltf_ext/document/document.h"
#include "gltf_ext/primitive/accessors.h"
#include "psplit/decode.h"
#include "tests/support/draco_clouds.h"
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

class PointCloudFiles : public CommandTest {
 protected:
  // Writes the first cloud whose name has both parts.
  const DracoStream& write_cloud(const std::string& file, const std::string& name, const std::string& coding) {
    for (const DracoStream& stream : small_draco_clouds())
      if (stream.name.starts_with(name) && stream.name.find(coding) != std::string::npos) {
        write(file, std::string(stream.bytes.begin(), stream.bytes.end()));
        return stream;
      }
    throw std::runtime_error("no such cloud");
  }
};

TEST_F(PointCloudFiles, DecodeToAGltfOfPoints) {
  for (const char* coding : {"kD-tree", "sequential"}) {
    SCOPED_TRACE(coding);
    const DracoStream& stream = write_cloud("a.drc", "positions, normals and colours of 64:", coding);
    must_run({"decode", path("a.drc"), path("a.glb")});
    EXPECT_TRUE(contains(err_, "1 primitive decoded"));
    const Document document = must(read_document(path("a.glb")));
    EXPECT_FALSE(document.json().contains("extensionsUsed"));
    const Json& primitive = document.json()["meshes"][0]["primitives"][0];
    EXPECT_EQ(primitive["mode"], 0);
    EXPECT_FALSE(primitive.contains("indices"));
    const Mesh expected = must(decode_draco(stream.bytes));
    ASSERT_EQ(primitive["attributes"].size(), expected.attributes.size());
    for (const Attribute& attribute : expected.attributes) {
      const AccessorData data =
          must(read_accessor(document, primitive["attributes"][attribute.semantic].get<int64_t>()));
      EXPECT_EQ(data.count, expected.point_count);
      EXPECT_EQ(data.component_type, attribute.component_type);
      EXPECT_EQ(data.normalized, attribute.normalized);
      EXPECT_TRUE(data.values == attribute.values) << attribute.semantic;
    }
    must_run({"validate", path("a.glb")});
  }
}

TEST_F(PointCloudFiles, AreInspected) {
  const DracoStream& stream = write_cloud("a.drc", "positions, normals and colours of 64:", "kD-tree");
  const Json found = json_of({"inspect", path("a.drc"), "--format", "json"})["primitives"][0];
  EXPECT_EQ(found["storage"], "draco");
  EXPECT_EQ(found["coding"], "cloud-kd-tree");
  EXPECT_EQ(found["faces"], 0);
  EXPECT_EQ(found["points"], 64);
  EXPECT_EQ(found["attributes"][0]["semantic"], "POSITION");
  EXPECT_EQ(found["attributes"][0]["bits"], 14);
  EXPECT_TRUE(found["attributes"][2]["bits"].is_null());
  must_run({"inspect", path("a.drc")});
  EXPECT_TRUE(contains(out_, "cloud-kd-tree"));
  EXPECT_TRUE(contains(out_, with_separators(stream.bytes.size())));
}

TEST_F(PointCloudFiles, AreValidIfTheyDecode) {
  const DracoStream& stream = write_cloud("a.drc", "positions, normals and colours of 64:", "kD-tree");
  must_run({"validate", path("a.drc")});
  EXPECT_TRUE(contains(out_, "a.drc: valid"));
  write("half.drc", std::string(stream.bytes.begin(), stream.bytes.begin() + std::ssize(stream.bytes) / 2));
  EXPECT_EQ(run({"validate", path("half.drc")}), 3);
  EXPECT_TRUE(contains(out_, "Draco stream: the stream ends early"));
}

TEST_F(PointCloudFiles, AreRefusedByOtherCommands) {
  write_cloud("a.drc", "positions of 64:", "kD-tree");
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"encode", path("a.drc"), path("a.glb")}, {"compare", path("a.drc")}})
    fails(5, words, "a point cloud: only triangles can be split");
}

// A PLY of points, with the properties that draco_encoder knows.
class PlyOfPoints : public PointCloudFiles {
 protected:
  static constexpr uint32_t kPoints = 300;

  void SetUp() override {
    PointCloudFiles::SetUp();
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(kPoints) + "\n";
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
      text += "property float " + std::string(name) + "\n";
    for (const char* name : {"red", "green", "blue"}) text += "property uchar " + std::string(name) + "\n";
    text += "end_header\n";
    for (uint32_t i = 0; i < kPoints; ++i) {
      const double angle = 0.1 * i;
      for (const double value :
           {3 * std::cos(angle), std::sin(angle), 0.01 * i, std::cos(angle), std::sin(angle), 0.0})
        text += std::to_string(value) + " ";
      text += std::to_string(i % 256) + " 7 255\n";
    }
    write("points.ply", text);
  }
  std::vector<uint8_t> bytes_of(const std::string& name) {
    const std::string text = read_bytes(path(name));
    return {text.begin(), text.end()};
  }
};

TEST_F(PlyOfPoints, BecomesADracoPointCloudAndComesBack) {
  const Mesh points = [&] {
    must_run({"decode", path("points.ply"), path("points.glb")});
    const Document document = must(read_document(path("points.glb")));
    const Json& primitive = document.json()["meshes"][0]["primitives"][0];
    EXPECT_EQ(primitive["mode"], 0);
    const AccessorData positions =
        must(read_accessor(document, primitive["attributes"]["POSITION"].get<int64_t>()));
    return Mesh{positions.count, {}, {{"POSITION", ComponentType::kFloat32, 3, false, positions.values}}};
  }();
  ASSERT_EQ(points.point_count, kPoints);
  for (const char* speed : {"3", "10"}) {
    must_run({"encode", path("points.ply"), "-o", path("a.drc"), "--quantize-position", "11", "--encode-speed",
              speed});
    const bool is_tree = speed == std::string("3");
    EXPECT_TRUE(contains(
        err_, is_tree ? "300 points as a kD-tree: POSITION has 11 bits, NORMAL has 10 bits, COLOR_0 is exact"
                      : "300 points, sequential: POSITION has 11 bits"))
        << err_;
    StreamDescription description;
    const Mesh decoded = must(decode_draco(bytes_of("a.drc"), &description));
    EXPECT_EQ(description.coding, is_tree ? StreamCoding::kCloudKdTree : StreamCoding::kCloudSequential);
    EXPECT_EQ(decoded.point_count, kPoints);
    EXPECT_NE(decoded.find("NORMAL"), nullptr);
    must_run({"decode", path("a.drc"), path("b.ply")});
    EXPECT_FALSE(contains(read_bytes(path("b.ply")), "element face"));
    must_run({"encode", path("b.ply"), path("c.drc"), "--lossless"});
    const Mesh again = must(decode_draco(bytes_of("c.drc")));
    EXPECT_TRUE(again.find("POSITION")->values == decoded.find("POSITION")->values);
  }
  must_run({"encode", path("points.ply"), path("new.drc"), "--dry-run"});
  EXPECT_FALSE(std::filesystem::exists(path("new.drc")));
}

TEST_F(PlyOfPoints, IsRefusedWhereOnlyTrianglesAre) {
  fails(5, {"encode", path("points.ply"), path("a.glb")}, "only a .drc file is made of points");
  fails(5, {"decode", path("points.ply"), path("a.stl")}, "no triangles");
  fails(1, {"encode", path("points.ply"), path("a.drc"), "--report", path("r.json")}, "--report");
  fails(1, {"encode", path("points.ply"), path("a.drc"), "--memory", "4GB"}, "--memory");
  fails(1, {"encode", path("points.ply"), path("a.drc"), "--quantize-position", "auto"}, "no edges");
}

// A mesh becomes the stream that `decode` makes of it.
TEST_F(PlyOfPoints, MeshesBecomeDracoStreams) {
  must_run({"generate", path("mesh.ply"), "--faces", "500"});
  must_run({"encode", path("mesh.ply"), path("a.drc")});
  must_run({"decode", path("mesh.ply"), path("b.drc")});
  EXPECT_EQ(read_bytes(path("a.drc")), read_bytes(path("b.drc")));
}

TEST_F(PointCloudFiles, WithoutPointsHaveNoGltf) {
  for (const DracoStream& stream : small_draco_clouds()) {
    if (stream.name != "sequential of 2.3, no points, level 0") continue;
    write("a.drc", std::string(stream.bytes.begin(), stream.bytes.end()));
    EXPECT_NE(run({"decode", path("a.drc"), path("a.glb")}), 0);
    EXPECT_FALSE(std::filesystem::exists(path("a.glb")));
    return;
  }
  FAIL() << "no such cloud";
}

}  // namespace
}  // namespace psplit
