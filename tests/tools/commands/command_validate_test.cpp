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

TEST_F(ValidateCommand, NamesThePatchOfAWrongBox) {
  must_run({"encode", sample(), path("boxes.glb"), "--patches", "4", "--boxes", "-q"});
  const auto boxes =
      json_of({"inspect", path("boxes.glb"), "--format", "json"}).at("primitives").at(0).at("boxes");
  EXPECT_EQ(boxes.at("streams").size(), 4u);
  std::string bytes = read_bytes(path("boxes.glb"));
  // The section is the only one of the head: its type, its length, and the bounds before the boxes.
  const size_t section = bytes.find(std::string("\x80\x30", 2), bytes.find("PSPL"));
  ASSERT_NE(section, std::string::npos);
  bytes[section + 2 + 24 + 6 * 2] = '\xff';
  write("wrong.glb", bytes);
  EXPECT_EQ(run({"validate", path("wrong.glb")}), 3) << err_;
  EXPECT_TRUE(
      contains(out_, "error [boxes] " + path("wrong.glb") + ": mesh 0, primitive 0, patch 2: its x is from "))
      << out_;
  must_run({"decode", path("wrong.glb"), path("plain.glb"), "-q"});
  // A section that cannot be read.
  bytes.replace(section + 2, 4, "\xff\xff\xff\xff");
  write("broken.glb", bytes);
  EXPECT_EQ(run({"validate", path("broken.glb")}), 3) << err_;
  EXPECT_TRUE(contains(out_, "error [boxes] " + path("broken.glb") + ": mesh 0, primitive 0: head: ")) << out_;
  must_run({"inspect", path("broken.glb")});
  EXPECT_TRUE(contains(err_, "broken.glb: mesh 0, primitive 0: head: boxes without bounds"));
}

// The stream decides; the accessor is corrected, and a line says so.
TEST_F(ValidateCommand, StockDracoThatItsAccessorsContradict) {
  must_run(
      {"encode", sample("terrain", "2000"), path("stock.gltf"), "--compat", "khr", "--patches", "1", "-q"});
  must_run({"validate", path("stock.gltf")});
  nlohmann::json asset = nlohmann::json::parse(read_bytes(path("stock.gltf")));
  const size_t positions = asset["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
  asset["accessors"][positions]["count"] = 140;
  write("wrong.gltf", asset.dump());
  EXPECT_EQ(run({"validate", path("wrong.gltf")}), 3);
  EXPECT_TRUE(contains(out_, "error [accessor-count] " + path("wrong.gltf") +
                                 ": mesh 0, primitive 0: POSITION: the accessor counts 140, the stream has "))
      << out_;
  must_run({"decode", path("wrong.gltf"), path("plain.glb")});
  EXPECT_TRUE(contains(err_, "POSITION: the accessor counts 140, the stream has ")) << err_;
  EXPECT_TRUE(contains(err_, ": corrected")) << err_;
}

TEST_F(ValidateCommand, ADryRunRefusesWhatDecodeRefuses) {
  const std::string split = split_sample();
  std::string bytes = read_bytes(split);
  bytes[bytes.rfind("DRACO")] = 'X';
  write("broken.glb", bytes);
  EXPECT_EQ(run({"decode", path("broken.glb"), path("plain.glb")}), 3) << err_;
  EXPECT_EQ(run({"encode", path("broken.glb"), path("out.glb"), "--dry-run"}), 3) << err_;
  EXPECT_EQ(run({"encode", path("broken.glb"), path("out.glb"), "--dry-run", "--memory", "1GB"}), 3) << err_;
  EXPECT_EQ(run({"expand", path("broken.glb"), path("out.glb")}), 3) << err_;
  must_run({"encode", split, path("out.glb"), "--dry-run"});
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
