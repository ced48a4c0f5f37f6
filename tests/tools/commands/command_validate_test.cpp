// gltf-psplit validate: verdicts, and the place of each finding.
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class ValidateCommand : public CommandOnSamples {};

TEST_F(ValidateCommand, AcceptsWhatEncodeWrites) {
  const CommandOutcome outcome = run_command({"validate", split_sample(), "--format", "json"});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(json.at("valid").get<bool>());
  EXPECT_EQ(json.at("errors"), 0);
  EXPECT_TRUE(json.at("findings").is_array());
}

TEST_F(ValidateCommand, FindsADamagedPatch) {
  std::string bytes = read_bytes(split_sample());
  const size_t stream = bytes.rfind("DRACO");
  ASSERT_NE(stream, std::string::npos);
  bytes[stream] = 'X';
  write("damaged.glb", bytes);
  const CommandOutcome outcome = run_command({"validate", path("damaged.glb"), "--format", "json"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_FALSE(nlohmann::json::parse(outcome.out).at("valid").get<bool>());
  EXPECT_NE(run_command({"decode", path("damaged.glb"), path("out.glb")}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
}

TEST_F(ValidateCommand, NamesThePlace) {
  std::string bytes = read_bytes(split_sample());
  bytes[bytes.rfind("DRACO")] = 'X';
  write("damaged.glb", bytes);
  const CommandOutcome text = run_command({"validate", path("damaged.glb")});
  EXPECT_EQ(text.code, 3);
  EXPECT_TRUE(contains(text.out, "error [decode] " + path("damaged.glb") + ": mesh 0, primitive 0, patch 3: "))
      << text.out;
  EXPECT_TRUE(contains(text.err, "damaged.glb: breaks the rules: 1 error")) << text.err;
  const CommandOutcome decoded = run_command({"decode", path("damaged.glb"), path("out.glb")});
  EXPECT_EQ(decoded.code, 3);
  EXPECT_TRUE(contains(decoded.err, "damaged.glb: mesh 0, primitive 0, patch 3: ")) << decoded.err;
}

TEST_F(ValidateCommand, SaysThatAMeshFileIsNotGltf) {
  ASSERT_EQ(run_command({"generate", path("a.ply"), "--faces", "200", "-q"}).code, 0);
  write("b.obj", "v 0 0 0\n");
  write("c.glb", "");
  write("d.gltf", std::string(100000, '['));
  for (const char* name : {"a.ply", "b.obj", "c.glb", "d.gltf"}) {
    const CommandOutcome outcome = run_command({"validate", path(name)});
    EXPECT_EQ(outcome.code, 3) << name;
    EXPECT_TRUE(contains(outcome.out, "not glTF: neither a GLB nor JSON")) << outcome.out;
  }
}

}  // namespace
}  // namespace psplit
