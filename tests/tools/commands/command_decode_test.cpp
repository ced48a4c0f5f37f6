// gltf-psplit decode: every backend and every input decode to the same bytes.
#include "decoder_cuda/psplit_cuda.h"
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class DecodeCommand : public CommandOnSamples {};

TEST_F(DecodeCommand, DecodesToPlainAndToStockDraco) {
  const std::string input = split_sample();
  const CommandOutcome plain = run_command({"decode", input, path("plain.gltf"), "-j", "2"});
  ASSERT_EQ(plain.code, 0) << plain.err;
  const auto plain_json = nlohmann::json::parse(read_bytes(path("plain.gltf")));
  EXPECT_FALSE(plain_json.contains("extensionsUsed"));
  EXPECT_TRUE(std::filesystem::exists(path(binary_of("plain.gltf"))));

  const CommandOutcome draco =
      run_command({"decode", input, path("draco.gltf"), "--to", "draco", "--backend", "draco"});
  ASSERT_EQ(draco.code, 0) << draco.err;
  const auto draco_json = nlohmann::json::parse(read_bytes(path("draco.gltf")));
  EXPECT_EQ(draco_json.at("extensionsUsed"), nlohmann::json::array({"KHR_draco_mesh_compression"}));
  EXPECT_TRUE(draco_json.at("meshes")
                  .at(0)
                  .at("primitives")
                  .at(0)
                  .at("extensions")
                  .contains("KHR_draco_mesh_compression"));
}

TEST_F(DecodeCommand, SaysWhatStockDracoCannotHold) {
  write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\nf 1 1 2\n");
  ASSERT_EQ(run({"decode", path("mesh.obj"), path("plain.gltf"), "-q"}), 0) << err_;
  ASSERT_EQ(run({"decode", path("plain.gltf"), path("draco.glb"), "--to", "draco", "--report", "-"}), 0)
      << err_;
  EXPECT_EQ(nlohmann::json::parse(out_).at("dropped_faces"), 1);
  EXPECT_TRUE(contains(err_, "dropped 1 degenerate face")) << err_;
}

TEST_F(DecodeCommand, EveryBackendDecodesToTheSameBytes) {
  const std::string split = split_sample();
  EXPECT_EQ(run_command({"decode", split, path("cpu.glb"), "--backend", "cpu"}).code, 0);
  EXPECT_EQ(run_command({"decode", split, path("draco.glb"), "--backend", "draco"}).code, 0);
  EXPECT_EQ(run_command({"decode", split, path("auto.glb")}).code, 0);
  EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("draco.glb")), true);
  EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("auto.glb")), true);
  EXPECT_EQ(run_command({"decode", split, path("bound.glb"), "--gpu-memory", "2MB"}).code, 0);
  EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("bound.glb")), true);
  const CommandOutcome cuda = run_command({"decode", split, path("cuda.glb"), "--backend", "cuda"});
  if (cuda_available(nullptr)) {
    EXPECT_EQ(cuda.code, 0) << cuda.err;
    EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("cuda.glb")), true);
  } else {
    EXPECT_EQ(cuda.code, 5);
    EXPECT_TRUE(contains(cuda.err, "no CUDA device to decode on: ")) << cuda.err;
  }
}

TEST_F(DecodeCommand, EveryBackendDecodesStockDracoToTheSameBytes) {
  const std::string drc = draco_sample(), stock = path("stock.gltf");
  for (const std::string& input : {drc, stock}) {
    const auto decoded = [&](const char* backend) {
      const CommandOutcome outcome =
          run_command({"decode", input, path("out.glb"), "--backend", backend, "-q"});
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      return read_bytes(path("out.glb"));
    };
    const std::string cpu = decoded("cpu");
    EXPECT_EQ(cpu.substr(0, 4), "glTF");
    EXPECT_FALSE(contains(cpu, "KHR_draco_mesh_compression"));
    EXPECT_TRUE(cpu == decoded("draco")) << input;
    EXPECT_TRUE(cpu == decoded("auto")) << input;
  }
  // The output has one node and one mesh, and nothing else.
  ASSERT_EQ(run_command({"decode", drc, path("out.gltf"), "-q"}).code, 0);
  const auto json = nlohmann::json::parse(read_bytes(path("out.gltf")));
  EXPECT_EQ(json.at("nodes"), nlohmann::json::parse(R"([{"mesh":0}])"));
  EXPECT_EQ(json.at("meshes").at(0).at("primitives").size(), 1u);
  EXPECT_EQ(json.at("accessors").size(), 2u);
  EXPECT_FALSE(json.contains("extensionsUsed"));
  EXPECT_FALSE(json.contains("extensionsRequired"));
}

TEST_F(DecodeCommand, DracoFilesAreReadByNameAndByContent) {
  const std::string drc = draco_sample();
  ASSERT_EQ(run_command({"decode", drc, path("named.glb"), "-q"}).code, 0);
  const CommandOutcome piped = run_command_on(drc, {"decode", "-", "-", "-q"});
  EXPECT_EQ(piped.code, 0) << piped.err;
  EXPECT_TRUE(piped.out == read_bytes(path("named.glb")));
  std::filesystem::copy(drc, path("stream.bin"));
  ASSERT_EQ(run_command({"decode", path("stream.bin"), path("by_content.glb"), "-q"}).code, 0);
  EXPECT_TRUE(read_bytes(path("by_content.glb")) == read_bytes(path("named.glb")));
  EXPECT_EQ(run_command({"decode", drc, path("again.glb"), "--to", "draco", "-q"}).code, 0);
  // All subcommands that read meshes accept the file.
  const CommandOutcome encoded =
      run_command({"encode", drc, path("split.glb"), "--patches", "3", "--report", "-", "-q"});
  ASSERT_EQ(encoded.code, 0) << encoded.err;
  EXPECT_EQ(nlohmann::json::parse(encoded.out).at("total").at("patches"), 3);
  EXPECT_FALSE(contains(read_bytes(path("split.glb")), "KHR_draco_mesh_compression"));
  EXPECT_EQ(run_command({"validate", path("split.glb")}).code, 0);
  EXPECT_EQ(run_command({"compare", drc, "--repeat", "1", "--patches", "2"}).code, 0);
  // `compare` refuses compressed assets: compared with these, patches would look better than they are.
  EXPECT_EQ(run_command({"compare", path("stock.gltf"), "--repeat", "1"}).code, 5);
}

TEST_F(DecodeCommand, DracoFilesThatHoldNoMeshSayWhy) {
  write("text.drc", "not Draco at all");
  write("empty.drc", "");
  write("version.drc", std::string("DRACO\x02\x01\x01\x01\x00\x00", 11));
  std::filesystem::create_directories(path("folder.drc"));
  const auto fails = [&](const char* command, const char* name, int code, const std::string& why) {
    std::vector<std::string> words = {command, path(name)};
    if (command == std::string("decode")) words.push_back(path("out.glb"));
    const CommandOutcome outcome = run_command(words);
    EXPECT_EQ(outcome.code, code) << command << " " << name;
    EXPECT_TRUE(contains(outcome.err, name + (": " + why))) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
  };
  for (const char* command : {"decode", "inspect"}) {
    fails(command, "text.drc", 3, "Draco stream: not a Draco mesh");
    fails(command, "empty.drc", 3, "the file is empty");
    fails(command, "folder.drc", 2, "");
    fails(command, "version.drc", 3, "Draco stream: ");
  }
  const std::vector<std::vector<std::string>> with_our_own = {
      {"decode", path("version.drc"), path("out.glb"), "--backend", "cpu"},
      {"inspect", path("version.drc"), "--backend", "cpu"}};
  for (const std::vector<std::string>& words : with_our_own) {
    const CommandOutcome older = run_command(words);
    EXPECT_EQ(older.code, 5);
    EXPECT_TRUE(contains(older.err, "version.drc: Draco stream: of bitstream ")) << older.err;
  }
}

}  // namespace
}  // namespace psplit
