// gltf-psplit generate: the same options make the same bytes.
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class GenerateCommand : public CommandOnSamples {};

TEST_F(GenerateCommand, GeneratesTheSameSceneTwice) {
  ASSERT_EQ(run_command({"generate", path("a.gltf"), "--shape", "scene", "--faces", "6000", "--seed", "3",
                         "--normals", "--texcoords"})
                .code,
            0);
  const auto json = nlohmann::json::parse(read_bytes(path("a.gltf")));
  EXPECT_EQ(json.at("meshes").size(), 6u);
  EXPECT_EQ(json.at("nodes").size(), 6u);
  EXPECT_EQ(json.at("scenes").at(0).at("nodes").size(), 6u);
  for (const auto& mesh : json.at("meshes"))
    for (const char* semantic : {"POSITION", "NORMAL", "TEXCOORD_0"})
      EXPECT_TRUE(mesh.at("primitives").at(0).at("attributes").contains(semantic));

  const auto bytes = [&](const char* seed) {
    EXPECT_EQ(run_command({"generate", path("b.glb"), "--faces", "2000", "--seed", seed, "-j", "3"}).code, 0);
    return read_bytes(path("b.glb"));
  };
  EXPECT_EQ(bytes("3"), bytes("3"));
  EXPECT_NE(bytes("3"), bytes("4"));
}

TEST_F(GenerateCommand, WritesTheSameMeshAsPly) {
  ASSERT_EQ(run_command({"generate", path("a.glb"), "--faces", "6000", "--normals"}).code, 0);
  ASSERT_EQ(run_command({"generate", path("a.ply"), "--faces", "6000", "--normals"}).code, 0);
  // The reader of PLY makes the same document from the file, so the encoder makes the same patches.
  const auto encoded = [&](const std::string& input) {
    EXPECT_EQ(run_command({"encode", path(input), path("out.glb"), "--patches", "3"}).code, 0);
    EXPECT_EQ(run_command({"decode", path("out.glb"), path("out.gltf")}).code, 0);
    const auto json = nlohmann::json::parse(read_bytes(path("out.gltf")));
    return read_bytes(path(json.at("buffers").at(0).at("uri").get<std::string>()));
  };
  EXPECT_EQ(encoded("a.ply"), encoded("a.glb"));
}

TEST_F(GenerateCommand, RefusesWhatPlyCannotHold) {
  EXPECT_EQ(run_command({"generate", path("a.ply"), "--shape", "scene"}).code, 1);
  EXPECT_EQ(run_command({"generate", path("a.ply"), "--texcoords"}).code, 1);
  EXPECT_FALSE(std::filesystem::exists(path("a.ply")));
}

TEST_F(GenerateCommand, NamesTheEndingsThatItWrites) {
  const CommandOutcome outcome = run_command({"generate", path("a.obj")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.err, ".glb, .ply or .gltf")) << outcome.err;
}

}  // namespace
}  // namespace psplit
