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

}  // namespace
}  // namespace psplit
