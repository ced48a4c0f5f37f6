// What all subcommands have in common: exit codes, streams, help, and failures.
#include "tests/tools/commands/sample_assets.h"
#include "tools/gltf_psplit/commands/commands.h"
#include "tools/gltf_psplit/report/exit_codes.h"

namespace psplit {
namespace {

class CommandLine : public CommandOnSamples {};

// A list of wrong command lines, which makes this function long.
TEST_F(CommandLine, WrongCommandLinesAreUsageErrors) {
  const std::vector<std::vector<std::string>> wrong{
      {},
      {"explode"},
      {"encode"},
      {"encode", "a.glb"},
      {"encode", "a.glb", "b.glb", "c.glb"},
      {"encode", "a.glb", "b.glb", "--patches", "0"},
      {"encode", "a.glb", "b.glb", "--patches", "-3"},
      {"encode", "a.glb", "b.glb", "--patches", "many"},
      {"encode", "a.glb", "b.glb", "--patch-faces", "0"},
      {"encode", "a.glb", "b.glb", "--patches", "2", "--patch-faces", "100"},
      {"encode", "a.glb", "b.glb", "--profile", "tiny"},
      {"encode", "a.glb", "b.glb", "--profile", "speed", "--gpu", "Voodoo"},
      {"encode", "a.glb", "b.glb", "--profile", "speed", "--gpu", "0"},
      {"encode", "a.glb", "b.glb", "--gpu", "H100"},
      {"encode", "a.glb", "b.glb", "--distance", "euclid"},
      {"encode", "a.glb", "b.glb", "--distance"},
      {"encode", "a.glb", "b.glb", "--quantize-position", "0"},
      {"encode", "a.glb", "b.glb", "--quantize-position", "31"},
      {"encode", "a.glb", "b.glb", "--quantize-position", "automatic"},
      {"encode", "a.glb", "b.glb", "--max-error", "0mm"},
      {"encode", "a.glb", "b.glb", "--max-error", "-1mm"},
      {"encode", "a.glb", "b.glb", "--max-error", "1 mile"},
      {"encode", "a.glb", "b.glb", "--max-error", "1mm", "--quantize-position", "12"},
      {"encode", "a.glb", "b.glb", "--max-error", "1mm", "--lossless"},
      {"compare", "a.glb", "--quantize-position", "auto"},
      {"encode", "a.glb", "b.glb", "--quantize-normal", "1"},
      {"encode", "a.glb", "b.glb", "--quantize-color", "8.5"},
      {"encode", "a.glb", "b.glb", "--lossless", "--quantize-position", "12"},
      {"encode", "a.glb", "b.glb", "--encode-speed", "11"},
      {"encode", "a.glb", "b.glb", "--encode-speed", "-1"},
      {"encode", "a.glb", "b.glb", "--quantization-volume", "world"},
      {"encode", "a.glb", "b.glb", "--fallback", "draco"},
      {"encode", "a.glb", "b.glb", "-j", "-1"},
      {"encode", "a.glb", "b.glb", "-q", "-v"},
      {"encode", "a.glb", "b.ply"},
      {"encode", "a.glb", "-", "--report", "-"},
      {"encode", "a.glb", "b.glb", "--report", "b.glb"},
      {"decode", "a.glb", "b.txt"},
      {"decode", "a.glb", "b.glb", "--to", "stl"},
      {"decode", "a.glb", "b.glb", "--backend", "abacus"},
      {"decode", "a.glb", "b.glb", "--gpu-memory", "plenty"},
      {"decode", "a.glb", "b.glb", "--gpu-memory", "-1"},
      {"inspect", "a.glb", "--format", "xml"},
      {"inspect", "a.glb", "--preview", "a.jpg"},
      {"inspect", "a.glb", "--preview", "-"},
      {"inspect", "a.glb", "--preview-size", "64"},
      {"inspect", "a.glb", "--preview", "a.png", "--preview-size", "15"},
      {"inspect", "a.glb", "--preview", "a.png", "--preview-size", "64x4097"},
      {"inspect", "a.glb", "--preview", "a.png", "--preview-size", "64x"},
      {"inspect", "a.glb", "--preview", "a.png", "--preview-size", "64x64x64"},
      {"inspect", "a.glb", "--preview", "a.png", "--preview-size", "-64"},
      {"inspect", "a.glb", "--preview", "a.png", "--preview-size", "99999999999"},
      {"inspect", "a.glb", "--preview", "a.png", "--preview-size", "large"},
      {"validate"},
      {"compare", "a.glb", "--patches", "1,0"},
      {"compare", "a.glb", "--repeat", "0"},
      {"compare", "a.glb", "--stock-speeds", "11"},
      {"compare", "a.glb", "--format", "pdf"},
      {"compare", "a.glb", "--tolerance", "0"},
      {"diff", "a.glb"},
      {"diff", "a.glb", "b.glb", "c.glb"},
      {"diff", "a.glb", "b.glb", "--format", "html"},
      {"diff", "a.glb", "b.glb", "--stock-speeds", "5"},
      {"diff", "a.glb", "b.glb", "--no-refine"},
      {"diff", "a.glb", "b.glb", "--encoder", "psplit"},
      {"compare", "a.glb", "--lossless", "--quantize-position", "12"},
      {"encode", "a.glb", "b.glb", "--lossless", "--quantization-volume", "mesh"},
      {"generate", "a.glb", "--shape", "teapot"},
      {"generate", "a.glb", "--faces", "0"},
      {"generate", "a.obj"},
  };
  for (const auto& words : wrong) {
    const CommandOutcome outcome = run_command(words);
    std::string line;
    for (const std::string& word : words) line += " " + word;
    EXPECT_EQ(outcome.code, 1) << line << "\n" << outcome.err;
    EXPECT_NE(outcome.err, "") << line;
    EXPECT_EQ(outcome.out, "") << line;
  }
  EXPECT_TRUE(contains(run_command({"encode", "a", "b.glb", "--encode-speed", "11"}).err, "--encode-speed"));
  fails(1, {"compare", "a.glb", "b.glb"}, "compare measures one file; `gltf-psplit diff A B` tells");
  fails(1, {"compare", "a.glb", "b.glb", "--tolerance", "0"}, "`gltf-psplit diff A B`");
}

TEST_F(CommandLine, MissingInputsAreIoErrorsAndLeaveNoOutput) {
  EXPECT_EQ(run({"encode", path("none.glb"), path("out.glb")}), 2);
  EXPECT_EQ(run({"encode", path("none.ply"), path("out.glb")}), 2);
  EXPECT_EQ(run({"decode", path("none.glb"), path("out.glb")}), 2);
  EXPECT_EQ(run({"inspect", path("none.glb")}), 2);
  EXPECT_EQ(run({"validate", path("none.glb")}), 2);
  if (has_draco()) fails(2, {"compare", path("none.gltf")}, "none.gltf");
  EXPECT_EQ(run({"generate", path("no/such/folder/out.glb"), "--faces", "1000"}), 2);
  EXPECT_EQ(file_count(), 0u);
}

TEST_F(CommandLine, MalformedInputsAreInvalid) {
  write("broken.gltf", "{\"asset\": {\"version\": ");
  EXPECT_EQ(run({"encode", path("broken.gltf"), path("out.glb")}), 3);
  EXPECT_EQ(run({"decode", path("broken.gltf"), path("out.glb")}), 3);
  EXPECT_EQ(run({"inspect", path("broken.gltf")}), 3);
  if (has_draco()) {
    EXPECT_EQ(run({"compare", path("broken.gltf")}), 3);
  }
  EXPECT_EQ(run({"validate", path("broken.gltf"), "--format", "json"}), 3);
  const auto json = nlohmann::json::parse(out_);
  EXPECT_FALSE(json.at("valid").get<bool>());
  EXPECT_EQ(json.at("findings").at(0).at("rule"), "asset");
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(CommandLine, DashIsStdinAndStdoutOfEveryCommand) {
  EXPECT_EQ(must_run({"generate", "-", "--faces", "1000"}).substr(0, 4), "glTF");
  EXPECT_EQ(file_count(), 0u);
  const std::string plain = sample(), split = split_sample();
  must_run({"decode", split, path("plain.glb"), "-q"});
  const CommandOutcome encoded = run_command_on(plain, {"encode", "-", "-", "--patches", "4"});
  EXPECT_EQ(encoded.code, 0) << encoded.err;
  EXPECT_EQ(encoded.out, read_bytes(split));
  const CommandOutcome decoded = run_command_on(split, {"decode", "-", "-"});
  EXPECT_EQ(decoded.code, 0) << decoded.err;
  EXPECT_EQ(decoded.out, read_bytes(path("plain.glb")));
  const CommandOutcome valid = run_command_on(split, {"validate", "-"});
  EXPECT_EQ(valid.code, 0) << valid.err;
  EXPECT_EQ(valid.out, "-: valid\n");
  EXPECT_EQ(run_command_on(split, {"inspect", "-"}).out, run_command({"inspect", split}).out);
  const CommandOutcome empty = run_command_on(null_device(), {"encode", "-", path("out.glb")});
  EXPECT_EQ(empty.code, 3);
  EXPECT_TRUE(contains(empty.err, "stdin: "));
}

TEST_F(CommandLine, BytesDoNotDependOnThreads) {
  const std::string input = sample("scene", "9000");
  for (const char* output : {"patches.glb", "plain.gltf", "stock.glb"}) {
    std::vector<std::string> first;
    for (const char* threads : {"1", "2", "7"}) {
      const std::string split = path("split.glb"), out = path(output);
      must_run({"encode", input, split, "--patch-faces", "400", "-j", threads, "-q"});
      std::vector<std::string> words = {"decode", split, out, "-j", threads, "-q"};
      if (out == path("stock.glb")) words.insert(words.end(), {"--to", "draco"});
      must_run(words);
      std::vector<std::string> bytes = {read_bytes(split), read_bytes(out)};
      if (out == path("plain.gltf")) bytes.push_back(read_bytes(path(binary_of("plain.gltf"))));
      if (first.empty()) first = bytes;
      EXPECT_TRUE(bytes == first) << output << " -j " << threads;
    }
  }
}

TEST_F(CommandLine, OtherFormatsAreNamedAsUnsupported) {
  write("cube.fbx", "Kaydara FBX Binary");
  for (const char* command : {"encode", "decode", "inspect", "compare", "diff"}) {
    if (command == std::string("compare") && !has_draco()) continue;
    std::vector<std::string> words = {command, path("cube.fbx")};
    if (command[0] == 'e' || command[0] == 'd') words.push_back(path("out.glb"));
    fails(5, words,
          "cube.fbx: a format that is not known; these are read: .gltf, .glb, .drc, .ply, .obj, .stl, .off");
  }
  // A file with the content of a glTF is read, whatever its name.
  std::filesystem::copy(sample(), path("asset.bin"));
  must_run({"encode", path("asset.bin"), path("out.glb")});
}

TEST_F(CommandLine, PointCloudsAreNotSplit) {
  const std::string vertices = "property float x\nproperty float y\nproperty float z\n";
  write("none.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + vertices + "end_header\n0 0 0\n");
  write("zero.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + vertices +
                        "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n");
  // A sequential point cloud of Draco 2.2, of a point that has no attributes. Clouds with positions can be
  // decoded.
  write("cloud.drc", std::string("DRACO\x02\x02\x00\x00\x00\x00\x01\x00\x00\x00\x00", 16));
  write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  for (const char* name : {"none.ply", "zero.ply", "points.obj"}) {
    fails(5, {"encode", path(name), path("out.glb")}, std::string(name) + ": has no triangles: only a .drc");
    EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
    must_run({"decode", path(name), path("points.glb")});
    must_run({"encode", path(name), path("points.drc")});
    EXPECT_TRUE(
        contains(err_, std::string(name) == "points.obj" ? "3 points as a kD-tree" : "1 point as a kD-tree"));
  }
  fails(5, {"encode", path("cloud.drc"), path("out.glb")}, "cloud.drc: a point cloud");
  fails(3, {"decode", path("cloud.drc"), path("out.glb")}, "cloud.drc: has no positions");
  fails(3, {"inspect", path("cloud.drc")}, "cloud.drc: has no positions");
  EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
}

TEST_F(CommandLine, UnreadableInputsAreIoErrors) {
  for (const char* name : {"folder.glb", "folder.ply", "folder.gltf"}) {
    std::filesystem::create_directories(path(name));
    fails(2, {"encode", path(name), path("out.glb")}, name);
  }
  // A missing buffer is also a file that cannot be read.
  write("asset.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"missing.bin"}]})");
  fails(2, {"encode", path("asset.gltf"), path("out.glb")}, "missing.bin");
}

TEST_F(CommandLine, FailuresNameMeshAndPrimitive) {
  write("far.gltf", R"({"asset":{"version":"2.0"},
    "buffers":[{"byteLength":40,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEJAA=="}],
    "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":3}],
    "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},
                 {"bufferView":1,"componentType":5121,"type":"SCALAR","count":3}],
    "meshes":[{"primitives":[{"mode":0,"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"indices":1}]}]})");
  fails(3, {"encode", path("far.gltf"), path("out.glb")},
        "far.gltf: mesh 0, primitive 1: index 2 is 9, but there are 3 points");
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(CommandLine, FailuresLeaveWhatWasThere) {
  const std::string input = sample();
  // After a failure the old file is unchanged, and nothing of the new file exists.
  write("out.glb", "old");
  write("broken.glb", "glTF");
  EXPECT_EQ(run({"encode", path("broken.glb"), path("out.glb")}), 3);
  EXPECT_EQ(read_bytes(path("out.glb")), "old");
  std::filesystem::create_directories(path("taken.glb"));
  EXPECT_EQ(run({"encode", input, path("taken.glb")}), 2);
  EXPECT_EQ(run({"encode", input, path("none/out.glb")}), 2);
  EXPECT_EQ(run({"encode", input, path("out.glb"), "--report", path("none/report.json")}), 2);
  EXPECT_EQ(file_count(), 4u);  // terrain.glb, out.glb, broken.glb, taken.glb
  // The output may be the input, if that is meant.
  must_run({"encode", input, input, "--patches", "3", "--force"});
  must_run({"validate", input});
  must_run({"decode", input, input, "-f"});
  EXPECT_EQ(file_count(), 4u);
}

}  // namespace
}  // namespace psplit
