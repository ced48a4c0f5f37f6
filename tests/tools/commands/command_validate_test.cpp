// gltf-psplit validate: verdicts, and the place of each finding.
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class ValidateCommand : public CommandOnSamples {};

TEST_F(ValidateCommand, AcceptsWhatEncodeWrites) {
  const auto json = json_of({"validate", split_sample(), "--format", "json"});
  EXPECT_TRUE(json.at("valid").get<bool>());
  EXPECT_EQ(json.at("errors"), 0);
  EXPECT_TRUE(json.at("findings").is_array());
}

TEST_F(ValidateCommand, NamesThePlaceOfADamagedPatch) {
  std::string bytes = read_bytes(split_sample());
  bytes[bytes.rfind("DRACO")] = 'X';
  write("damaged.glb", bytes);
  EXPECT_EQ(run({"validate", path("damaged.glb")}), 3) << err_;
  EXPECT_TRUE(contains(out_, "error [decode] " + path("damaged.glb") + ": mesh 0, primitive 0, patch 3: "));
  EXPECT_TRUE(contains(err_, "damaged.glb: breaks the rules: 1 error"));
  fails(3, {"decode", path("damaged.glb"), path("out.glb")}, "damaged.glb: mesh 0, primitive 0, patch 3: ");
  EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
  EXPECT_EQ(run({"validate", path("damaged.glb"), "--format", "json"}), 3) << err_;
  EXPECT_FALSE(nlohmann::json::parse(out_).at("valid").get<bool>());
}

TEST_F(ValidateCommand, SaysThatAMeshFileIsNotGltf) {
  must_run({"generate", path("a.ply"), "--faces", "200", "-q"});
  write("b.obj", "v 0 0 0\n");
  write("c.glb", "");
  write("d.gltf", std::string(100000, '['));
  for (const char* name : {"a.ply", "b.obj", "c.glb", "d.gltf"}) {
    EXPECT_EQ(run({"validate", path(name)}), 3) << err_;
    EXPECT_TRUE(contains(out_, "not glTF: neither a GLB nor JSON"));
  }
}

}  // namespace
}  // namespace psplit
