// gltf-psplit generate: the same options make the same bytes.
#include <set>

#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class GenerateCommand : public CommandOnSamples {};

TEST_F(GenerateCommand, GeneratesTheSameSceneTwice) {
  must_run({"generate", path("a.gltf"), "--shape", "scene", "--faces", "6000", "--seed", "3", "--normals",
            "--texcoords"});
  const auto json = read_json("a.gltf");
  EXPECT_EQ(json.at("meshes").size(), 6u);
  EXPECT_EQ(json.at("nodes").size(), 6u);
  EXPECT_EQ(json.at("scenes").at(0).at("nodes").size(), 6u);
  for (const auto& mesh : json.at("meshes"))
    for (const char* semantic : {"POSITION", "NORMAL", "TEXCOORD_0"})
      EXPECT_TRUE(mesh.at("primitives").at(0).at("attributes").contains(semantic));

  const auto bytes = [&](const char* seed) {
    must_run({"generate", path("b.glb"), "--faces", "2000", "--seed", seed, "-j", "3"});
    return read_bytes(path("b.glb"));
  };
  EXPECT_EQ(bytes("3"), bytes("3"));
  EXPECT_NE(bytes("3"), bytes("4"));
}

TEST_F(GenerateCommand, WritesTheSameMeshAsPly) {
  must_run({"generate", path("a.glb"), "--faces", "6000", "--normals"});
  must_run({"generate", path("a.ply"), "--faces", "6000", "--normals"});
  // The reader of PLY makes the same document from the file, so the encoder makes the same patches.
  const auto encoded = [&](const std::string& input) {
    must_run({"encode", path(input), path("out.glb"), "--patches", "3"});
    must_run({"decode", path("out.glb"), path("out.gltf")});
    return read_bytes(path(binary_of("out.gltf")));
  };
  EXPECT_EQ(encoded("a.ply"), encoded("a.glb"));
}

TEST_F(GenerateCommand, GeneratesACharacterThatEncodes) {
  must_run({"generate", path("hero.gltf"), "--shape", "character", "--faces", "3000"});
  must_run({"validate", path("hero.gltf")});
  const auto json = read_json("hero.gltf");
  const auto& mesh = json.at("meshes").at(0);
  EXPECT_EQ(mesh.at("weights").size(), 8u);
  EXPECT_EQ(mesh.at("extras").at("targetNames").size(), 8u);
  EXPECT_EQ(mesh.at("primitives").at(0).at("targets").size(), 8u);
  const auto& joints = json.at("skins").at(0).at("joints");
  EXPECT_EQ(joints.size(), 17u);
  // The clip moves the root, every joint and the targets.
  EXPECT_EQ(json.at("animations").at(0).at("channels").size(), 1 + joints.size() + 1);
  // All joints hang on the first.
  std::set<size_t> children{joints.at(0).get<size_t>()};
  for (const auto& node : json.at("nodes"))
    for (const auto& child : node.value("children", nlohmann::json::array()))
      children.insert(child.get<size_t>());
  EXPECT_EQ(children.size(), joints.size());
  must_run({"encode", path("hero.gltf"), path("small.glb"), "--condense", "--always-patches"});
  must_run({"diff", path("hero.gltf"), path("small.glb")});
  EXPECT_LT(8 * read_bytes(path("small.glb")).size(), read_bytes(path(binary_of("hero.gltf"))).size());
}

TEST_F(GenerateCommand, RefusesWhatItCannotWrite) {
  EXPECT_EQ(run({"generate", path("a.ply"), "--shape", "scene"}), 1);
  EXPECT_EQ(run({"generate", path("a.ply"), "--texcoords"}), 1);
  fails(1, {"generate", path("a.ply"), "--shape", "character"}, "no skin and no morph targets");
  EXPECT_FALSE(std::filesystem::exists(path("a.ply")));
  fails(1, {"generate", path("a.obj")}, ".glb, .ply or .gltf");
}

}  // namespace
}  // namespace psplit
