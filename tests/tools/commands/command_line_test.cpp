// gltf-psplit as its users meet it: exit codes, streams, help, and the shape of its JSON.
#include "tools/gltf_psplit/commands/command_line.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "decoder_cuda/psplit_cuda.h"
#include "encoder/draco/stock_stream.h"
#include "tests/support/test_folder.h"
#include "tools/gltf_psplit/report/exit_codes.h"

namespace psplit {
namespace {

using testing::internal::CaptureStderr;
using testing::internal::CaptureStdout;
using testing::internal::GetCapturedStderr;
using testing::internal::GetCapturedStdout;

const char* const kCommands[] = {"encode", "batch", "decode", "inspect", "validate", "compare", "generate"};

struct Outcome {
  int code = -1;
  std::string out, err;
};

Outcome run(std::vector<std::string> words) {
  words.insert(words.begin(), "gltf-psplit");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  CaptureStdout();
  CaptureStderr();
  Outcome outcome;
  outcome.code = run_command_line(static_cast<int>(argv.size()), argv.data(), "1.2.3");
  outcome.out = GetCapturedStdout();
  outcome.err = GetCapturedStderr();
  return outcome;
}

// With the file as stdin.
Outcome run_on(const std::string& input, const std::vector<std::string>& words) {
  EXPECT_NE(std::freopen(input.c_str(), "rb", stdin), nullptr);
  Outcome outcome = run(words);
  EXPECT_NE(std::freopen("/dev/null", "rb", stdin), nullptr);
  return outcome;
}

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

class CommandLine : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  size_t file_count() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  // A small plain asset.
  std::string sample(const std::string& shape = "terrain", const std::string& faces = "3000") const {
    const Outcome outcome =
        run({"generate", path(shape + ".glb"), "--shape", shape, "--faces", faces, "--seed", "7"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return path(shape + ".glb");
  }
  std::string split_sample() const {
    const Outcome outcome = run({"encode", sample(), path("split.glb"), "--patches", "4", "-q"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return path("split.glb");
  }

  // The .bin that a .gltf refers to.
  std::string binary_of(const std::string& gltf) const {
    const auto json = nlohmann::json::parse(read_bytes(path(gltf)));
    return json.at("buffers").at(0).at("uri").get<std::string>();
  }

  // The same as stock Draco, as glTF and as the stream alone.
  std::string stock_sample() const {
    const Outcome outcome =
        run({"decode", sample("terrain", "3000"), path("stock.gltf"), "--to", "draco", "-q"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return path("stock.gltf");
  }
  std::string draco_sample() const {
    const auto json = nlohmann::json::parse(read_bytes(stock_sample()));
    const auto& extension = json.at("meshes").at(0).at("primitives").at(0).at("extensions");
    const auto& view =
        json.at("bufferViews").at(extension.at("KHR_draco_mesh_compression").at("bufferView").get<size_t>());
    const std::string stream =
        read_bytes(path(binary_of("stock.gltf")))
            .substr(view.value("byteOffset", size_t{0}), view.at("byteLength").get<size_t>());
    EXPECT_EQ(stream.substr(0, 5), "DRACO");
    write("mesh.drc", stream);
    return path("mesh.drc");
  }

  TestFolder folder_;
};

TEST_F(CommandLine, HelpAndVersionGoToStdoutAndSucceed) {
  const Outcome help = run({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* command : kCommands) EXPECT_NE(help.out.find(command), std::string::npos) << command;
  for (const ExitCode& exit : exit_codes()) EXPECT_NE(help.out.find(exit.meaning), std::string::npos);
  EXPECT_EQ(help.err, "");

  const Outcome version = run({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out, "gltf-psplit 1.2.3\n");

  for (const char* command : kCommands) {
    const Outcome one = run({command, "--help"});
    EXPECT_EQ(one.code, 0) << command;
    for (const char* option : {"--help", "--quiet", "--verbose", "--threads"})
      EXPECT_NE(one.out.find(option), std::string::npos) << command << " " << option;
  }
}

TEST_F(CommandLine, ExitCodesAreTheIssuesNumbers) {
  std::vector<int> codes;
  for (const ExitCode& exit : exit_codes()) codes.push_back(static_cast<int>(exit.code));
  EXPECT_EQ(codes, (std::vector<int>{0, 1, 2, 3, 4, 5, 7}));
}

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
      {"compare", "a.glb", "b.glb", "--format", "html"},
      {"compare", "a.glb", "b.glb", "--stock-speeds", "5"},
      {"compare", "a.glb", "b.glb", "--no-refine"},
      {"compare", "a.glb", "--lossless", "--quantize-position", "12"},
      {"encode", "a.glb", "b.glb", "--lossless", "--quantization-volume", "mesh"},
      {"generate", "a.glb", "--shape", "teapot"},
      {"generate", "a.glb", "--faces", "0"},
      {"generate", "a.obj"},
  };
  for (const auto& words : wrong) {
    const Outcome outcome = run(words);
    std::string line;
    for (const std::string& word : words) line += " " + word;
    EXPECT_EQ(outcome.code, 1) << line << "\n" << outcome.err;
    EXPECT_NE(outcome.err, "") << line;
    EXPECT_EQ(outcome.out, "") << line;
  }
  EXPECT_NE(run({"encode", "a", "b.glb", "--encode-speed", "11"}).err.find("--encode-speed"),
            std::string::npos);
}

TEST_F(CommandLine, MissingInputsAreIoErrorsAndLeaveNoOutput) {
  EXPECT_EQ(run({"encode", path("none.glb"), path("out.glb")}).code, 2);
  EXPECT_EQ(run({"encode", path("none.ply"), path("out.glb")}).code, 2);
  EXPECT_EQ(run({"decode", path("none.glb"), path("out.glb")}).code, 2);
  EXPECT_EQ(run({"inspect", path("none.glb")}).code, 2);
  EXPECT_EQ(run({"validate", path("none.glb")}).code, 2);
  const Outcome compare = run({"compare", path("none.gltf")});
  EXPECT_EQ(compare.code, 2);
  EXPECT_NE(compare.err.find("none.gltf"), std::string::npos) << compare.err;
  EXPECT_EQ(run({"generate", path("no/such/folder/out.glb"), "--faces", "1000"}).code, 2);
  EXPECT_EQ(file_count(), 0u);
}

TEST_F(CommandLine, MalformedInputsAreInvalid) {
  write("broken.gltf", "{\"asset\": {\"version\": ");
  EXPECT_EQ(run({"encode", path("broken.gltf"), path("out.glb")}).code, 3);
  EXPECT_EQ(run({"decode", path("broken.gltf"), path("out.glb")}).code, 3);
  EXPECT_EQ(run({"inspect", path("broken.gltf")}).code, 3);
  EXPECT_EQ(run({"compare", path("broken.gltf")}).code, 3);
  const Outcome validate = run({"validate", path("broken.gltf"), "--format", "json"});
  EXPECT_EQ(validate.code, 3);
  const auto json = nlohmann::json::parse(validate.out);
  EXPECT_FALSE(json.at("valid").get<bool>());
  EXPECT_EQ(json.at("findings").at(0).at("rule"), "asset");
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(CommandLine, EncodeSaysInOneLineWhatItDid) {
  const std::string input = sample();
  const Outcome loud = run({"encode", input, path("a.glb"), "--patches", "4"});
  EXPECT_EQ(loud.code, 0) << loud.err;
  EXPECT_EQ(loud.out, "");
  EXPECT_NE(loud.err.find("4 patches"), std::string::npos) << loud.err;
  EXPECT_EQ(std::ranges::count(loud.err, '\n'), 1) << loud.err;
  const Outcome quiet = run({"encode", input, path("b.glb"), "--patches", "4", "-q", "-j", "7"});
  EXPECT_EQ(quiet.code, 0);
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
  EXPECT_GT(run({"encode", input, path("b.glb"), "-v"}).err.size(), loud.err.size());
}

TEST_F(CommandLine, EncodeReportsAsJson) {
  const Outcome outcome = run({"encode", sample("scene", "6000"), path("out.glb"), "--patch-faces", "500",
                               "--report", path("report.json")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
  EXPECT_TRUE(report.at("verified").get<bool>());
  EXPECT_EQ(report.at("primitives").size(), 6u);
  uint64_t patches = 0, bytes = 0;
  for (const auto& primitive : report.at("primitives")) {
    patches += primitive.at("patches").get<uint64_t>();
    bytes += primitive.at("bytes").at("total").get<uint64_t>();
    EXPECT_EQ(primitive.at("input").at("faces"), primitive.at("faces"));
  }
  EXPECT_EQ(report.at("total").at("patches"), patches);
  EXPECT_EQ(report.at("total").at("bytes").at("total"), bytes);
  for (const char* key : {"replication", "balance", "partition_ms", "encode_ms", "verify_ms", "wall_ms"})
    EXPECT_TRUE(report.at("total").at(key).is_number()) << key;
}

TEST_F(CommandLine, ProfilesChooseThePatchSizeAndExplicitOptionsWin) {
  const std::string input = sample("blob", "12000");
  const auto patches = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"encode", input, path("out.glb"), "--report", "-", "-q"});
    return nlohmann::json::parse(run(options).out).at("total").at("patches").get<int>();
  };
  EXPECT_EQ(patches({"--profile", "speed"}), 3);
  EXPECT_EQ(patches({"--profile", "speed", "--gpu", "h100"}), 27);  // of 440 faces at least
  EXPECT_EQ(patches({"--profile", "speed", "--gpu", "1", "--patch-faces", "6000"}), 2);
  EXPECT_EQ(patches({"--profile", "balanced"}), patches({}));
  EXPECT_EQ(patches({}), 1);
  EXPECT_EQ(patches({"--min-faces", "5000"}), 2);
  EXPECT_EQ(patches({"--profile", "speed", "--patches", "3"}), 3);
  EXPECT_EQ(patches({"--patches", "3", "--min-faces", "50000"}), 1);
  EXPECT_EQ(patches({"--profile", "size", "--patch-faces", "2000"}), 6);
}

TEST_F(CommandLine, DistanceTakesThePapersMethod) {
  const std::string input = sample("blob", "12000");
  const auto encoded = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"encode", input, path("out.glb"), "--patches", "10", "-q"});
    const Outcome outcome = run(options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(run({"validate", path("out.glb")}).code, 0);
    return read_bytes(path("out.glb"));
  };
  const std::string levels = encoded({}), dijkstra = encoded({"--distance", "dijkstra"});
  const std::string geodesic = encoded({"--distance", "geodesic"});
  EXPECT_NE(levels, dijkstra);
  EXPECT_NE(levels, geodesic);
  EXPECT_NE(dijkstra, geodesic);
  EXPECT_EQ(geodesic, encoded({"--distance", "geodesic", "-j", "3"}));
  EXPECT_NE(levels, encoded({"--no-refine"}));
}

TEST_F(CommandLine, InspectHasTheIssuesKeys) {
  const std::string input = split_sample();
  const Outcome outcome = run({"inspect", input, "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(json.at("primitives").size(), 1u);
  const auto& primitive = json.at("primitives").at(0);
  EXPECT_EQ(primitive.at("mesh"), 0);
  EXPECT_EQ(primitive.at("primitive"), 0);
  EXPECT_EQ(primitive.at("patches"), 4);
  EXPECT_EQ(primitive.at("container_version"), 2);
  const double points = primitive.at("points").get<double>();
  EXPECT_NEAR(primitive.at("replication").get<double>(), primitive.at("references").get<double>() / points,
              1e-12);
  EXPECT_GE(primitive.at("balance").get<double>(), 1.0);
  const auto& bytes = primitive.at("bytes");
  EXPECT_EQ(bytes.at("payload").get<int>() + bytes.at("directory").get<int>() + bytes.at("stitch").get<int>(),
            bytes.at("total").get<int>());
  EXPECT_NEAR(primitive.at("bits_per_point").get<double>(), 8 * bytes.at("total").get<double>() / points, 1e-9);
  const auto& position = primitive.at("attributes").at(0);
  EXPECT_EQ(position.at("semantic"), "POSITION");
  EXPECT_EQ(position.at("componentType"), 5126);
  EXPECT_EQ(position.at("bits"), 14);

  const Outcome text = run({"inspect", input});
  EXPECT_EQ(text.code, 0);
  EXPECT_NE(text.out.find("POSITION 14 bits"), std::string::npos) << text.out;
}

TEST_F(CommandLine, InspectOfAPlainAssetListsNoPatches) {
  const Outcome outcome = run({"inspect", sample(), "--format", "json", "-q"});
  EXPECT_EQ(outcome.code, 0);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(json.at("primitives").empty());
  EXPECT_EQ(json.at("others").at(0).at("storage"), "plain");
}

TEST_F(CommandLine, InspectDrawsAPreviewBesideItsTable) {
  const std::string split = split_sample();
  const auto draw = [&](const std::string& input, const char* size, const char* threads) {
    const Outcome outcome =
        run({"inspect", input, "--preview", path("a.png"), "--preview-size", size, "-j", threads});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, run({"inspect", input}).out);
    EXPECT_NE(outcome.err.find("a.png: "), std::string::npos) << outcome.err;
    const std::string png = read_bytes(path("a.png"));
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    return png;
  };
  // Width and height follow the name of the first chunk.
  const std::string png = draw(split, "300x200", "1");
  EXPECT_EQ(png.substr(12, 12), std::string("IHDR\0\0\x01\x2c\0\0\0\xc8", 12));
  EXPECT_TRUE(draw(split, "300x200", "3") == png);
  EXPECT_EQ(draw(split, "64", "2").substr(16, 8), std::string("\0\0\0\x40\0\0\0\x40", 8));
  // Not only patches: plain and stock Draco, glTF and not.
  for (const std::string& input : {sample(), draco_sample(), stock_sample()}) draw(input, "64", "2");
}

TEST_F(CommandLine, PreviewsThatCannotBeDrawnOrWrittenSayWhy) {
  const std::string input = split_sample();
  const Outcome unwritable = run({"inspect", input, "--preview", path("no/such/folder/a.png")});
  EXPECT_EQ(unwritable.code, 2);
  EXPECT_NE(unwritable.err.find("no/such/folder/a.png"), std::string::npos) << unwritable.err;
  EXPECT_EQ(unwritable.out, "");
  write("empty.gltf", R"({"asset": {"version": "2.0"}})");
  const Outcome empty = run({"inspect", path("empty.gltf"), "--preview", path("a.png")});
  EXPECT_EQ(empty.code, 5);
  EXPECT_NE(empty.err.find("empty.gltf: nothing to draw: "), std::string::npos) << empty.err;
  std::string bytes = read_bytes(input);
  bytes[bytes.rfind("DRACO")] = 'X';
  write("damaged.glb", bytes);
  const Outcome damaged = run({"inspect", path("damaged.glb"), "--preview", path("a.png")});
  EXPECT_EQ(damaged.code, 3);
  EXPECT_NE(damaged.err.find("damaged.glb: mesh 0, primitive 0, patch 3: "), std::string::npos) << damaged.err;
  EXPECT_FALSE(std::filesystem::exists(path("a.png")));
}

TEST_F(CommandLine, InspectShowsAStockDracoStreamAsOnePatch) {
  const std::string drc = draco_sample(), stock = path("stock.gltf");
  ASSERT_EQ(run({"decode", drc, path("plain.gltf"), "-q"}).code, 0);
  const auto plain = nlohmann::json::parse(read_bytes(path("plain.gltf")));
  const auto& accessors = plain.at("accessors");
  const auto& geometry = plain.at("meshes").at(0).at("primitives").at(0);
  const auto count_of = [&](const nlohmann::json& accessor) {
    return accessors.at(accessor.get<size_t>()).at("count").get<int>();
  };
  for (const std::string& input : {drc, stock}) {
    const Outcome outcome = run({"inspect", input, "--format", "json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome.err;
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_TRUE(json.at("others").empty());
    ASSERT_EQ(json.at("primitives").size(), 1u);
    const auto& primitive = json.at("primitives").at(0);
    EXPECT_EQ(primitive.at("storage"), "draco");
    EXPECT_EQ(primitive.at("coding"), "edgebreaker");
    EXPECT_EQ(primitive.at("patches"), 1);
    EXPECT_EQ(primitive.at("faces").get<int>() * 3, count_of(geometry.at("indices")));
    EXPECT_EQ(primitive.at("points").get<int>(), count_of(geometry.at("attributes").at("POSITION")));
    EXPECT_EQ(primitive.at("references"), 0);
    EXPECT_EQ(primitive.at("balance"), 1.0);
    EXPECT_EQ(primitive.at("bytes"), nlohmann::json({{"payload", std::filesystem::file_size(drc)},
                                                     {"directory", 0},
                                                     {"stitch", 0},
                                                     {"total", std::filesystem::file_size(drc)}}));
    EXPECT_NEAR(primitive.at("bits_per_point").get<double>(),
                8 * static_cast<double>(std::filesystem::file_size(drc)) / primitive.at("points").get<double>(),
                1e-9);
    ASSERT_EQ(primitive.at("attributes").size(), 1u);
    EXPECT_EQ(primitive.at("attributes").at(0),
              nlohmann::json({{"semantic", "POSITION"}, {"componentType", 5126}, {"bits", 14}}));
    const Outcome text = run({"inspect", input});
    EXPECT_EQ(text.code, 0);
    EXPECT_NE(text.out.find("POSITION 14 bits"), std::string::npos) << text.out;
    EXPECT_NE(text.out.find("edgebreaker"), std::string::npos) << text.out;
  }
  EXPECT_EQ(run_on(drc, {"inspect", "-"}).out, run({"inspect", drc}).out);
  for (const std::string& input : {drc, stock, split_sample()})
    EXPECT_EQ(run({"inspect", input, "--backend", "cpu"}).out,
              run({"inspect", input, "--backend", "draco"}).out);
}

TEST_F(CommandLine, InspectTellsCodingsAndStoragesApart) {
  const auto first_of = [&](const std::string& input) {
    const Outcome outcome = run({"inspect", input, "--format", "json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out).at("primitives").at(0);
  };
  const auto split = first_of(split_sample());
  EXPECT_EQ(split.at("storage"), "patches");
  EXPECT_EQ(split.at("coding"), "edgebreaker");
  const std::string out = path("valence.glb");
  ASSERT_EQ(run({"decode", path("terrain.glb"), out, "--to", "draco", "--encode-speed", "0", "-q"}).code, 0);
  EXPECT_EQ(first_of(out).at("coding"), "edgebreaker-valence");
  // Nothing but degenerate faces: Edgebreaker cannot hold them.
  Mesh flat;
  flat.point_count = 2;
  flat.faces = {{0, 0, 1}, {1, 1, 0}};
  flat.attributes.push_back({"POSITION", ComponentType::kFloat32, 3, false, Array<std::byte>(24)});
  const Expected<StockStream> stream = encode_stock_stream(flat, std::vector<AttributeCoding>(1), 5);
  ASSERT_TRUE(stream.ok()) << stream.status().to_string();
  write("flat.drc", std::string(stream->bytes.begin(), stream->bytes.end()));
  EXPECT_EQ(first_of(path("flat.drc")).at("coding"), "sequential");
}

TEST_F(CommandLine, InspectNamesTheStreamThatIsBroken) {
  std::string bytes = read_bytes(draco_sample());
  write("short.drc", bytes.substr(0, bytes.size() - 20));
  const Outcome shortened = run({"inspect", path("short.drc")});
  EXPECT_EQ(shortened.code, 3);
  EXPECT_EQ(shortened.out, "");
  EXPECT_NE(shortened.err.find("short.drc: Draco stream: "), std::string::npos) << shortened.err;
  std::string binary = read_bytes(path(binary_of("stock.gltf")));
  binary[binary.find("DRACO")] = 'X';
  write(binary_of("stock.gltf"), binary);
  const Outcome broken = run({"inspect", path("stock.gltf")});
  EXPECT_EQ(broken.code, 3);
  EXPECT_NE(broken.err.find("stock.gltf: mesh 0, primitive 0: Draco stream: not a Draco mesh"),
            std::string::npos)
      << broken.err;
}

TEST_F(CommandLine, ValidateAcceptsWhatEncodeWrites) {
  const Outcome outcome = run({"validate", split_sample(), "--format", "json"});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(json.at("valid").get<bool>());
  EXPECT_EQ(json.at("errors"), 0);
  EXPECT_TRUE(json.at("findings").is_array());
}

TEST_F(CommandLine, ValidateFindsADamagedPatch) {
  std::string bytes = read_bytes(split_sample());
  const size_t stream = bytes.rfind("DRACO");
  ASSERT_NE(stream, std::string::npos);
  bytes[stream] = 'X';
  write("damaged.glb", bytes);
  const Outcome outcome = run({"validate", path("damaged.glb"), "--format", "json"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_FALSE(nlohmann::json::parse(outcome.out).at("valid").get<bool>());
  EXPECT_NE(run({"decode", path("damaged.glb"), path("out.glb")}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
}

TEST_F(CommandLine, DecodesToPlainAndToStockDraco) {
  const std::string input = split_sample();
  const Outcome plain = run({"decode", input, path("plain.gltf"), "-j", "2"});
  ASSERT_EQ(plain.code, 0) << plain.err;
  const auto plain_json = nlohmann::json::parse(read_bytes(path("plain.gltf")));
  EXPECT_FALSE(plain_json.contains("extensionsUsed"));
  EXPECT_TRUE(std::filesystem::exists(path(binary_of("plain.gltf"))));

  const Outcome draco = run({"decode", input, path("draco.gltf"), "--to", "draco", "--backend", "draco"});
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

TEST_F(CommandLine, ComparesInOneTable) {
  const std::string input = sample("gyroid", "4000");
  const Outcome outcome =
      run({"compare", "--patches", "2,8", input, "--repeat", "2", "-j", "3", "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_GT(json.at("faces").get<int>(), 3000);
  EXPECT_GT(json.at("points").get<int>(), 1000);
  for (const char* key : {"bytes", "encode_ms", "decode_ms"})
    EXPECT_GT(json.at("stock").at(key).get<double>(), 0);
  for (const char* key : {"bytes", "decode_ms"}) EXPECT_GT(json.at("meshopt").at(key).get<double>(), 0);
  ASSERT_EQ(json.at("splits").size(), 2u);
  EXPECT_EQ(json.at("splits").at(0).at("patches"), 2);
  EXPECT_EQ(json.at("splits").at(1).at("patches"), 8);
  for (const auto& split : json.at("splits")) {
    for (const char* key :
         {"patch_faces", "bytes", "overhead", "replication", "balance", "partition_ms", "encode_ms"})
      EXPECT_TRUE(split.at(key).is_number()) << key;
    EXPECT_NEAR(split.at("overhead").get<double>(),
                split.at("bytes").get<double>() / json.at("stock").at("bytes").get<double>() - 1, 1e-9);
    // Every decoder, on one thread and on as many as -j says.
    ASSERT_EQ(split.at("decode").size(), 4u);
    for (size_t i = 0; i < 4; ++i) {
      const auto& decode = split.at("decode").at(i);
      EXPECT_EQ(decode.at("backend"), i < 2 ? "cpu" : "draco");
      EXPECT_EQ(decode.at("threads"), i % 2 == 0 ? 1 : 3);
      EXPECT_LE(decode.at("min_ms").get<double>(), decode.at("median_ms").get<double>());
      EXPECT_LE(decode.at("median_ms").get<double>(), decode.at("max_ms").get<double>());
      EXPECT_NEAR(decode.at("speedup").get<double>() * decode.at("median_ms").get<double>(),
                  json.at("stock").at("decode_ms").get<double>(), 1e-6);
    }
  }
  ASSERT_EQ(json.at("stock_speeds").size(), 3u);
  EXPECT_EQ(json.at("stock_speeds").at(1), json.at("stock"));
  EXPECT_GT(json.at("meshopt_plain").at("bytes").get<int>(), json.at("meshopt").at("bytes").get<int>());
  EXPECT_EQ(json.at("splits").at(0).at("stages").size(), 5u);
  const auto& environment = json.at("environment");
  for (const char* key : {"cpu", "psplit", "draco", "meshoptimizer", "zstd", "compiler", "date"})
    EXPECT_NE(environment.at(key).get<std::string>(), "") << key;
  EXPECT_EQ(environment.at("command_line"), "gltf-psplit compare --patches 2,8 " +
                                                std::filesystem::path(input).filename().string() +
                                                " --repeat 2 -j 3 --format json");

  const Outcome text = run({"compare", input, "--repeat", "1", "--stock-speeds", "7", "-o", path("table.txt")});
  EXPECT_EQ(text.code, 0);
  EXPECT_EQ(text.out, "");
  const std::string table = read_bytes(path("table.txt"));
  for (const char* word : {"stock Draco, speed 5", "stock Draco, speed 7", "meshopt ", " + zstd", "psplit"})
    EXPECT_NE(table.find(word), std::string::npos) << table;
  EXPECT_EQ(table.find("speed 10"), std::string::npos);
  EXPECT_EQ(run({"compare", input, "--repeat", "1", "-o", path("no/such/folder.txt")}).code, 2);
}

TEST_F(CommandLine, TellsTheCommandAsAShellTakesIt) {
  const std::string input = path("it's a mesh.glb");
  std::filesystem::copy(sample("terrain", "300"), input);
  const Outcome outcome = run({"compare", input, "--repeat", "1", "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json.at("environment").at("command_line"),
            "gltf-psplit compare 'it'\\''s a mesh.glb' --repeat 1 --format json");
}

TEST_F(CommandLine, ReportsSayWhatIsGainedAndNameNoFolder) {
  const std::string input = sample("gyroid", "4000"), folder = std::filesystem::path(input).parent_path();
  for (const std::string format : {"text", "json", "html"}) {
    const std::string report = path("report." + format);
    const Outcome outcome =
        run({"compare", input, "--patches", "2,4", "--repeat", "1", "--format", format, "--output=" + report});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::string text = read_bytes(report);
    EXPECT_EQ(text.find(folder), std::string::npos) << format;
    EXPECT_NE(text.find(std::filesystem::path(input).filename()), std::string::npos) << format;
    EXPECT_NE(text.find("stock Draco on"), std::string::npos) << format;
    if (format != "json") continue;
    const auto json = nlohmann::json::parse(text);
    EXPECT_TRUE(json.at("headline").get<std::string>().starts_with("In ")) << json.at("headline");
    const auto& recommendation = json.at("recommendation");
    EXPECT_TRUE(recommendation.at("patches") == 2 || recommendation.at("patches") == 4);
    EXPECT_NE(recommendation.at("text").get<std::string>(), "");
    EXPECT_FALSE(json.at("noise").empty());  // one round is too few
    EXPECT_TRUE(json.at("environment").at("command_line").get<std::string>().ends_with("--output=report.json"));
    EXPECT_EQ(json.at("meshopt").at("version"), json.at("environment").at("meshoptimizer"));
    EXPECT_TRUE(json.at("meshopt").at("codec_version").is_number());
    const auto& asset = json.at("asset");
    EXPECT_EQ(asset.at("texture_bytes"), 0);
    EXPECT_NEAR(asset.at("bytes").get<double>(), static_cast<double>(std::filesystem::file_size(input)), 300);
    EXPECT_EQ(asset.at("bytes_with_stock").get<int>() - asset.at("other_bytes").get<int>(),
              json.at("stock").at("bytes"));
  }
}

TEST_F(CommandLine, ComparesFromOnePatchAPrimitiveOnByDefault) {
  const std::string input = sample("scene", "12000");
  const Outcome outcome = run({"compare", input, "--repeat", "1", "--format", "json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto splits = nlohmann::json::parse(outcome.out).at("splits");
  ASSERT_GE(splits.size(), 2u);
  EXPECT_EQ(splits.front().at("patches"), 6);  // primitives
  EXPECT_EQ(splits.front().at("replication"), 0);
  for (size_t i = 1; i < splits.size(); ++i)
    EXPECT_GT(splits.at(i).at("patches"), splits.at(i - 1).at("patches"));
}

TEST_F(CommandLine, ComparesLosslessAndWithoutRefinement) {
  const std::string input = sample("gyroid", "4000");
  const auto compared = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"compare", input, "--patches", "9", "--repeat", "1", "--format", "json"});
    const Outcome outcome = run(options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto plain = compared({}), lossless = compared({"--lossless"}), jagged = compared({"--no-refine"});
  // Three floats for each point, and more.
  EXPECT_GT(lossless.at("stock").at("bytes").get<int>(), 12 * lossless.at("points").get<int>());
  EXPECT_LT(plain.at("stock").at("bytes").get<int>(), 6 * plain.at("points").get<int>());
  EXPECT_GT(lossless.at("meshopt").at("bytes").get<int>(), plain.at("meshopt").at("bytes").get<int>());
  const auto replication = [](const auto& json) { return json.at("splits").at(0).at("replication"); };
  EXPECT_EQ(replication(lossless), replication(plain));
  EXPECT_GT(replication(jagged).template get<double>(), 1.1 * replication(plain).template get<double>());
  EXPECT_NE(replication(compared({"--distance", "dijkstra"})), replication(plain));
  const Outcome text = run({"compare", input, "--repeat", "1", "--patches", "2", "--lossless", "--no-refine"});
  EXPECT_NE(text.out.find("lossless, borders not refined"), std::string::npos) << text.out;
}

TEST_F(CommandLine, ComparesOnlyUncompressedAssets) { EXPECT_EQ(run({"compare", split_sample()}).code, 5); }

TEST_F(CommandLine, GeneratesTheSameSceneTwice) {
  ASSERT_EQ(run({"generate", path("a.gltf"), "--shape", "scene", "--faces", "6000", "--seed", "3", "--normals",
                 "--texcoords"})
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
    EXPECT_EQ(run({"generate", path("b.glb"), "--faces", "2000", "--seed", seed, "-j", "3"}).code, 0);
    return read_bytes(path("b.glb"));
  };
  EXPECT_EQ(bytes("3"), bytes("3"));
  EXPECT_NE(bytes("3"), bytes("4"));
}

TEST_F(CommandLine, DashIsStdoutAsGlb) {
  const Outcome outcome = run({"generate", "-", "--faces", "1000"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out.substr(0, 4), "glTF");
  EXPECT_EQ(file_count(), 0u);
}

TEST_F(CommandLine, DashIsStdinAndStdoutOfEveryCommand) {
  const std::string plain = sample(), split = split_sample();
  ASSERT_EQ(run({"decode", split, path("plain.glb"), "-q"}).code, 0);
  const Outcome encoded = run_on(plain, {"encode", "-", "-", "--patches", "4"});
  EXPECT_EQ(encoded.code, 0) << encoded.err;
  EXPECT_EQ(encoded.out, read_bytes(split));
  const Outcome decoded = run_on(split, {"decode", "-", "-"});
  EXPECT_EQ(decoded.code, 0) << decoded.err;
  EXPECT_EQ(decoded.out, read_bytes(path("plain.glb")));
  const Outcome valid = run_on(split, {"validate", "-"});
  EXPECT_EQ(valid.code, 0) << valid.err;
  EXPECT_EQ(valid.out, "-: valid\n");
  EXPECT_EQ(run_on(split, {"inspect", "-"}).out, run({"inspect", split}).out);
  const Outcome empty = run_on("/dev/null", {"encode", "-", path("out.glb")});
  EXPECT_EQ(empty.code, 3);
  EXPECT_NE(empty.err.find("stdin: "), std::string::npos) << empty.err;
}

TEST_F(CommandLine, CompatKhrWritesWhatLoadersOfTodayOpen) {
  const Outcome outcome = run({"encode", sample(), path("khr.glb"), "--patches", "4", "--compat", "khr",
                               "--report", path("report.json"), "-q"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto total = nlohmann::json::parse(read_bytes(path("report.json"))).at("total");
  EXPECT_EQ(total.at("patches"), 4);
  EXPECT_GT(total.at("replication"), 0.0);
  EXPECT_EQ(total.at("bytes").at("total"), total.at("bytes").at("payload"));
  const Outcome inspected = run({"inspect", path("khr.glb"), "--format", "json"});
  ASSERT_EQ(inspected.code, 0) << inspected.err;
  const auto primitives = nlohmann::json::parse(inspected.out).at("primitives");
  ASSERT_EQ(primitives.size(), 4u);
  for (const auto& primitive : primitives) EXPECT_EQ(primitive.at("storage"), "draco");
  EXPECT_EQ(run({"decode", path("khr.glb"), path("plain.glb"), "-q"}).code, 0);
}

TEST_F(CommandLine, BytesDoNotDependOnThreads) {
  const std::string input = sample("scene", "9000");
  for (const char* output : {"patches.glb", "plain.gltf", "stock.glb"}) {
    std::vector<std::string> first;
    for (const char* threads : {"1", "2", "7"}) {
      const std::string split = path("split.glb"), out = path(output);
      ASSERT_EQ(run({"encode", input, split, "--patch-faces", "400", "-j", threads, "-q"}).code, 0);
      std::vector<std::string> words = {"decode", split, out, "-j", threads, "-q"};
      if (out == path("stock.glb")) words.insert(words.end(), {"--to", "draco"});
      ASSERT_EQ(run(words).code, 0);
      std::vector<std::string> bytes = {read_bytes(split), read_bytes(out)};
      if (out == path("plain.gltf")) bytes.push_back(read_bytes(path(binary_of("plain.gltf"))));
      if (first.empty()) first = bytes;
      EXPECT_TRUE(bytes == first) << output << " -j " << threads;
    }
  }
}

TEST_F(CommandLine, OtherFormatsAreNamedAsUnsupported) {
  write("cube.fbx", "Kaydara FBX Binary");
  for (const char* command : {"encode", "decode", "inspect", "compare"}) {
    std::vector<std::string> words = {command, path("cube.fbx")};
    if (command[0] == 'e' || command[0] == 'd') words.push_back(path("out.glb"));
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, 5);
    EXPECT_NE(outcome.err.find("cube.fbx: no format that is read; .gltf, .glb, .drc, .ply, .obj, .stl, .off"),
              std::string::npos)
        << outcome.err;
  }
  // What is glTF by content is read, whatever its name.
  std::filesystem::copy(sample(), path("asset.bin"));
  EXPECT_EQ(run({"encode", path("asset.bin"), path("out.glb")}).code, 0);
}

TEST_F(CommandLine, PointCloudsAreUnsupported) {
  const std::string vertices = "property float x\nproperty float y\nproperty float z\n";
  write("none.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + vertices + "end_header\n0 0 0\n");
  write("zero.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + vertices +
                        "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n");
  // Draco 2.2, a point cloud, sequential.
  write("cloud.drc", std::string("DRACO\x02\x02\x00\x00\x00\x00\x01\x00\x00\x00\x00", 16));
  write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  for (const char* command : {"encode", "decode"})
    for (const char* name : {"none.ply", "zero.ply", "cloud.drc", "points.obj"}) {
      const Outcome outcome = run({command, path(name), path("out.glb")});
      EXPECT_EQ(outcome.code, 5) << name;
      EXPECT_NE(outcome.err.find(std::string(name) + ": a point cloud"), std::string::npos) << outcome.err;
      EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
    }
  EXPECT_EQ(run({"inspect", path("cloud.drc")}).code, 5);
}

TEST_F(CommandLine, UnreadableInputsAreIoErrors) {
  for (const char* name : {"folder.glb", "folder.ply", "folder.gltf"}) {
    std::filesystem::create_directories(path(name));
    const Outcome outcome = run({"encode", path(name), path("out.glb")});
    EXPECT_EQ(outcome.code, 2) << name;
    EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
  }
  // A buffer that is missing is a file that cannot be read, too.
  write("asset.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"missing.bin"}]})");
  const Outcome outcome = run({"encode", path("asset.gltf"), path("out.glb")});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("missing.bin"), std::string::npos) << outcome.err;
}

TEST_F(CommandLine, FailuresNameMeshAndPrimitive) {
  write("far.gltf", R"({"asset":{"version":"2.0"},
    "buffers":[{"byteLength":40,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEJAA=="}],
    "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":3}],
    "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},
                 {"bufferView":1,"componentType":5121,"type":"SCALAR","count":3}],
    "meshes":[{"primitives":[{"mode":0,"attributes":{"POSITION":0}},{"attributes":{"POSITION":0},"indices":1}]}]})");
  const Outcome outcome = run({"encode", path("far.gltf"), path("out.glb")});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.err.find("far.gltf: mesh 0, primitive 1: index 2 is 9, but there are 3 points"),
            std::string::npos)
      << outcome.err;
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(CommandLine, FailuresLeaveWhatWasThere) {
  const std::string input = sample();
  // Neither the new file nor a part of it, and the old one whole.
  write("out.glb", "old");
  write("broken.glb", "glTF");
  EXPECT_EQ(run({"encode", path("broken.glb"), path("out.glb")}).code, 3);
  EXPECT_EQ(read_bytes(path("out.glb")), "old");
  std::filesystem::create_directories(path("taken.glb"));
  EXPECT_EQ(run({"encode", input, path("taken.glb")}).code, 2);
  EXPECT_EQ(run({"encode", input, path("none/out.glb")}).code, 2);
  EXPECT_EQ(run({"encode", input, path("out.glb"), "--report", path("none/report.json")}).code, 2);
  EXPECT_EQ(file_count(), 4u);  // terrain.glb, out.glb, broken.glb, taken.glb
  // In its own place.
  EXPECT_EQ(run({"encode", input, input, "--patches", "3"}).code, 0);
  EXPECT_EQ(run({"validate", input}).code, 0);
  EXPECT_EQ(run({"decode", input, input}).code, 0);
  EXPECT_EQ(file_count(), 4u);
}

TEST_F(CommandLine, EncodeReportsWhatItLeavesAndDrops) {
  write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\nf 1 1 2\n");
  const auto total = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words = {"encode", path("mesh.obj"), path("out.glb"), "--report", "-", "-q"};
    words.insert(words.end(), options.begin(), options.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(report.at("input"), path("mesh.obj"));
    EXPECT_EQ(report.at("output"), path("out.glb"));
    EXPECT_EQ(report.at("primitives").at(0).at("mesh"), 0);
    return report;
  };
  const auto kept = total({"--always-patches", "--keep-degenerate"});
  EXPECT_EQ(kept.at("total").at("input"), nlohmann::json::parse(R"({"faces":3,"points":4,"bytes":66})"));
  EXPECT_EQ(kept.at("total").at("faces"), 3);
  EXPECT_EQ(kept.at("total").at("residue_faces"), 1);
  EXPECT_EQ(kept.at("total").at("dropped_faces"), 0);
  const auto dropped = total({"--always-patches", "--no-verify", "-j", "2"});
  EXPECT_EQ(dropped.at("total").at("faces"), 2);
  EXPECT_EQ(dropped.at("total").at("dropped_faces"), 1);
  EXPECT_FALSE(dropped.at("verified").get<bool>());
  EXPECT_EQ(dropped.at("threads"), 2);

  const Outcome again = run({"encode", path("out.glb"), path("again.glb"), "--report", path("report.json")});
  EXPECT_EQ(again.code, 0);
  EXPECT_NE(again.err.find("mesh 0, primitive 0 is left as it is: already in patches"), std::string::npos);
  EXPECT_NE(again.err.find("warning: nothing to encode"), std::string::npos);
  const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
  EXPECT_EQ(report.at("primitives").at(0).at("skipped"), "already in patches");
}

TEST_F(CommandLine, FallbackAndVolumeReachTheFile) {
  const std::string input = sample("scene", "3000");
  ASSERT_EQ(
      run({"encode", input, path("out.gltf"), "--fallback", "uncompressed", "--quantization-volume", "scene"})
          .code,
      0);
  const auto json = nlohmann::json::parse(read_bytes(path("out.gltf")));
  EXPECT_FALSE(json.contains("extensionsRequired"));
  for (const auto& accessor : json.at("accessors")) EXPECT_TRUE(accessor.contains("bufferView"));
  EXPECT_EQ(run({"validate", path("out.gltf")}).code, 0);
}

TEST_F(CommandLine, ValidateNamesThePlace) {
  std::string bytes = read_bytes(split_sample());
  bytes[bytes.rfind("DRACO")] = 'X';
  write("damaged.glb", bytes);
  const Outcome text = run({"validate", path("damaged.glb")});
  EXPECT_EQ(text.code, 3);
  EXPECT_NE(text.out.find("error [decode] " + path("damaged.glb") + ": mesh 0, primitive 0, patch 3: "),
            std::string::npos)
      << text.out;
  EXPECT_NE(text.err.find("damaged.glb: breaks the rules: 1 error"), std::string::npos) << text.err;
  const Outcome decoded = run({"decode", path("damaged.glb"), path("out.glb")});
  EXPECT_EQ(decoded.code, 3);
  EXPECT_NE(decoded.err.find("damaged.glb: mesh 0, primitive 0, patch 3: "), std::string::npos) << decoded.err;
}

TEST_F(CommandLine, EveryBackendDecodesToTheSameBytes) {
  const std::string split = split_sample();
  EXPECT_EQ(run({"decode", split, path("cpu.glb"), "--backend", "cpu"}).code, 0);
  EXPECT_EQ(run({"decode", split, path("draco.glb"), "--backend", "draco"}).code, 0);
  EXPECT_EQ(run({"decode", split, path("auto.glb")}).code, 0);
  EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("draco.glb")), true);
  EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("auto.glb")), true);
  EXPECT_EQ(run({"decode", split, path("bound.glb"), "--gpu-memory", "2MB"}).code, 0);
  EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("bound.glb")), true);
  const Outcome cuda = run({"decode", split, path("cuda.glb"), "--backend", "cuda"});
  if (cuda_available(nullptr)) {
    EXPECT_EQ(cuda.code, 0) << cuda.err;
    EXPECT_EQ(read_bytes(path("cpu.glb")) == read_bytes(path("cuda.glb")), true);
  } else {
    EXPECT_EQ(cuda.code, 5);
    EXPECT_NE(cuda.err.find("no CUDA device to decode on: "), std::string::npos) << cuda.err;
  }
}

TEST_F(CommandLine, EveryBackendDecodesStockDracoToTheSameBytes) {
  const std::string drc = draco_sample(), stock = path("stock.gltf");
  for (const std::string& input : {drc, stock}) {
    const auto decoded = [&](const char* backend) {
      const Outcome outcome = run({"decode", input, path("out.glb"), "--backend", backend, "-q"});
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      return read_bytes(path("out.glb"));
    };
    const std::string cpu = decoded("cpu");
    EXPECT_EQ(cpu.substr(0, 4), "glTF");
    EXPECT_EQ(cpu.find("KHR_draco_mesh_compression"), std::string::npos);
    EXPECT_TRUE(cpu == decoded("draco")) << input;
    EXPECT_TRUE(cpu == decoded("auto")) << input;
  }
  // One node, the file's one mesh, and nothing else.
  ASSERT_EQ(run({"decode", drc, path("out.gltf"), "-q"}).code, 0);
  const auto json = nlohmann::json::parse(read_bytes(path("out.gltf")));
  EXPECT_EQ(json.at("nodes"), nlohmann::json::parse(R"([{"mesh":0}])"));
  EXPECT_EQ(json.at("meshes").at(0).at("primitives").size(), 1u);
  EXPECT_EQ(json.at("accessors").size(), 2u);
  EXPECT_FALSE(json.contains("extensionsUsed"));
  EXPECT_FALSE(json.contains("extensionsRequired"));
}

TEST_F(CommandLine, DracoFilesAreReadByNameAndByContent) {
  const std::string drc = draco_sample();
  ASSERT_EQ(run({"decode", drc, path("named.glb"), "-q"}).code, 0);
  const Outcome piped = run_on(drc, {"decode", "-", "-", "-q"});
  EXPECT_EQ(piped.code, 0) << piped.err;
  EXPECT_TRUE(piped.out == read_bytes(path("named.glb")));
  std::filesystem::copy(drc, path("stream.bin"));
  ASSERT_EQ(run({"decode", path("stream.bin"), path("by_content.glb"), "-q"}).code, 0);
  EXPECT_TRUE(read_bytes(path("by_content.glb")) == read_bytes(path("named.glb")));
  EXPECT_EQ(run({"decode", drc, path("again.glb"), "--to", "draco", "-q"}).code, 0);
  // Every command that reads meshes takes it.
  const Outcome encoded = run({"encode", drc, path("split.glb"), "--patches", "3", "--report", "-", "-q"});
  ASSERT_EQ(encoded.code, 0) << encoded.err;
  EXPECT_EQ(nlohmann::json::parse(encoded.out).at("total").at("patches"), 3);
  EXPECT_EQ(read_bytes(path("split.glb")).find("KHR_draco_mesh_compression"), std::string::npos);
  EXPECT_EQ(run({"validate", path("split.glb")}).code, 0);
  EXPECT_EQ(run({"compare", drc, "--repeat", "1", "--patches", "2"}).code, 0);
  // Compared with what is compressed already, patches would look better than they are.
  EXPECT_EQ(run({"compare", path("stock.gltf"), "--repeat", "1"}).code, 5);
}

TEST_F(CommandLine, DracoFilesThatHoldNoMeshSayWhy) {
  write("text.drc", "not Draco at all");
  write("empty.drc", "");
  write("version.drc", std::string("DRACO\x02\x01\x01\x01\x00\x00", 11));
  std::filesystem::create_directories(path("folder.drc"));
  const auto fails = [&](const char* command, const char* name, int code, const std::string& why) {
    std::vector<std::string> words = {command, path(name)};
    if (command == std::string("decode")) words.push_back(path("out.glb"));
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, code) << command << " " << name;
    EXPECT_NE(outcome.err.find(name + (": " + why)), std::string::npos) << outcome.err;
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
    const Outcome older = run(words);
    EXPECT_EQ(older.code, 5);
    EXPECT_NE(older.err.find("version.drc: Draco stream: of bitstream "), std::string::npos) << older.err;
  }
}

TEST_F(CommandLine, MeshFilesAreReadByTheirExtension) {
  write("tetrahedron.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Outcome outcome =
      run({"encode", path("tetrahedron.obj"), path("out.glb"), "--always-patches", "--report", "-", "-q"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("total").at("faces"), 4);
}

}  // namespace
}  // namespace psplit
