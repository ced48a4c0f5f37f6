// gltf-psplit decode: every backend and every input decode to the same bytes.
#include "psplit/cuda.h"
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class DecodeCommand : public CommandOnSamples {};

TEST_F(DecodeCommand, DecodesToPlainAndToStockDraco) {
  const std::string input = split_sample();
  must_run({"decode", input, path("plain.gltf"), "-j", "2"});
  const auto plain_json = read_json("plain.gltf");
  EXPECT_FALSE(plain_json.contains("extensionsUsed"));
  EXPECT_TRUE(std::filesystem::exists(path(binary_of("plain.gltf"))));

  must_run({"decode", input, path("draco.gltf"), "--to", "draco", "--backend", has_draco() ? "draco" : "cpu"});
  const auto draco_json = read_json("draco.gltf");
  EXPECT_EQ(draco_json.at("extensionsUsed"), nlohmann::json::array({"KHR_draco_mesh_compression"}));
  const auto& primitive = draco_json.at("meshes").at(0).at("primitives").at(0);
  EXPECT_TRUE(primitive.at("extensions").contains("KHR_draco_mesh_compression"));
}

TEST_F(DecodeCommand, SaysWhatStockDracoCannotHold) {
  write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\nf 1 1 2\n");
  must_run({"decode", path("mesh.obj"), path("plain.gltf"), "-q"});
  const auto report =
      json_of({"decode", path("plain.gltf"), path("draco.glb"), "--to", "draco", "--report", "-"});
  EXPECT_EQ(report.at("dropped_faces"), 1);
  EXPECT_TRUE(contains(err_, "dropped 1 degenerate face"));
}

TEST_F(DecodeCommand, SaysIfLibdracoMayDecodeAStream) {
  write("old.drc", std::string("DRACO\2\1\1\1\0\0", 11) + std::string(100, '\1'));
  EXPECT_NE(run({"decode", path("old.drc"), path("plain.glb")}), 0);
  EXPECT_EQ(contains(err_, "of bitstream 2.1, which is older"), !has_draco()) << err_;
  EXPECT_EQ(contains(err_, "built without libdraco, which may decode it"), !has_draco()) << err_;
}

TEST_F(DecodeCommand, EveryBackendDecodesToTheSameBytes) {
  const std::string split = split_sample();
  const auto decoded = [&](const char* option, const char* value) {
    must_run({"decode", split, path("out.glb"), option, value});
    return read_bytes(path("out.glb"));
  };
  const std::string cpu = decoded("--backend", "cpu");
  if (has_draco()) {
    EXPECT_TRUE(decoded("--backend", "draco") == cpu);
  }
  EXPECT_TRUE(decoded("--backend", "auto") == cpu);
  EXPECT_TRUE(decoded("--gpu-memory", "2MB") == cpu);
  if (cuda_available(nullptr)) {
    EXPECT_TRUE(decoded("--backend", "cuda") == cpu);
  } else {
    fails(5, {"decode", split, path("a.glb"), "--backend", "cuda"}, "no CUDA device to decode on: ");
  }
}

TEST_F(DecodeCommand, EveryBackendDecodesStockDracoToTheSameBytes) {
  const std::string drc = draco_sample(), stock = path("stock.gltf");
  for (const std::string& input : {drc, stock}) {
    const auto decoded = [&](const char* backend) {
      must_run({"decode", input, path("out.glb"), "--backend", backend, "-q"});
      return read_bytes(path("out.glb"));
    };
    const std::string cpu = decoded("cpu");
    EXPECT_EQ(cpu.substr(0, 4), "glTF");
    EXPECT_FALSE(contains(cpu, "KHR_draco_mesh_compression"));
    if (has_draco()) {
      EXPECT_TRUE(cpu == decoded("draco")) << input;
    }
    EXPECT_TRUE(cpu == decoded("auto")) << input;
  }
  // The output has one node and one mesh, and nothing else.
  must_run({"decode", drc, path("out.gltf"), "-q"});
  const auto json = read_json("out.gltf");
  EXPECT_EQ(json.at("nodes"), nlohmann::json::parse(R"([{"mesh":0}])"));
  EXPECT_EQ(json.at("meshes").at(0).at("primitives").size(), 1u);
  EXPECT_EQ(json.at("accessors").size(), 2u);
  EXPECT_FALSE(json.contains("extensionsUsed"));
  EXPECT_FALSE(json.contains("extensionsRequired"));
}

TEST_F(DecodeCommand, DracoFilesAreReadByNameAndByContent) {
  const std::string drc = draco_sample();
  must_run({"decode", drc, path("named.glb"), "-q"});
  const CommandOutcome piped = run_command_on(drc, {"decode", "-", "-", "-q"});
  EXPECT_EQ(piped.code, 0) << piped.err;
  EXPECT_TRUE(piped.out == read_bytes(path("named.glb")));
  std::filesystem::copy(drc, path("stream.bin"));
  must_run({"decode", path("stream.bin"), path("by_content.glb"), "-q"});
  EXPECT_TRUE(read_bytes(path("by_content.glb")) == read_bytes(path("named.glb")));
  must_run({"decode", drc, path("again.glb"), "--to", "draco", "-q"});
  // All subcommands that read meshes accept the file.
  const auto report = json_of({"encode", drc, path("split.glb"), "--patches", "3", "--report", "-", "-q"});
  EXPECT_EQ(report.at("total").at("patches"), 3);
  EXPECT_FALSE(contains(read_bytes(path("split.glb")), "KHR_draco_mesh_compression"));
  must_run({"validate", path("split.glb")});
  if (has_draco()) must_run({"compare", drc, "--repeat", "1", "--patches", "2"});
  // `compare` refuses compressed assets: compared with these, patches would look better than they are.
  EXPECT_EQ(run({"compare", path("stock.gltf"), "--repeat", "1"}), 5);
}

TEST_F(DecodeCommand, DracoFilesThatHoldNoMeshSayWhy) {
  write("text.drc", "not Draco at all");
  write("empty.drc", "");
  write("version.drc", std::string("DRACO\x02\x01\x01\x01\x00\x00", 11));
  std::filesystem::create_directories(path("folder.drc"));
  const auto refuses = [&](const char* command, const char* name, int code, const std::string& why) {
    std::vector<std::string> words = {command, path(name)};
    if (command == std::string("decode")) words.push_back(path("out.glb"));
    fails(code, words, name + (": " + why));
    EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
  };
  for (const char* command : {"decode", "inspect"}) {
    refuses(command, "text.drc", 3, "Draco stream: not a Draco mesh");
    refuses(command, "empty.drc", 3, "the file is empty");
    refuses(command, "folder.drc", 2, "");
    if (has_draco()) refuses(command, "version.drc", 3, "Draco stream: ");
  }
  const std::string version = path("version.drc"), reason = "version.drc: Draco stream: of bitstream ";
  fails(5, {"decode", version, path("out.glb"), "--backend", "cpu"}, reason);
  fails(5, {"inspect", version, "--backend", "cpu"}, reason);
}

}  // namespace
}  // namespace psplit
