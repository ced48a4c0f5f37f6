// gltf-psplit inspect: its JSON, its table, and the preview.
#include <fstream>
#include <regex>

#include "psplit/encode.h"
#include "tests/support/stock_stream.h"
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class InspectCommand : public CommandOnSamples {};

TEST_F(InspectCommand, JsonHasTheDocumentedKeys) {
  const std::string input = split_sample();
  const auto json = json_of({"inspect", input, "--format", "json"});
  ASSERT_EQ(json.at("primitives").size(), 1u);
  const auto& primitive = json.at("primitives").at(0);
  EXPECT_EQ(primitive.at("mesh"), 0);
  EXPECT_EQ(primitive.at("primitive"), 0);
  EXPECT_EQ(primitive.at("patches"), 4);
  const double points = primitive.at("points").get<double>();
  EXPECT_NEAR(primitive.at("replication").get<double>(), primitive.at("references").get<double>() / points,
              1e-12);
  EXPECT_GE(primitive.at("balance").get<double>(), 1.0);
  const auto& bytes = primitive.at("bytes");
  EXPECT_EQ(bytes.at("payload").get<int>() + bytes.at("directory").get<int>() + bytes.at("stitch").get<int>(),
            bytes.at("total").get<int>());
  EXPECT_EQ(bytes.at("head"), 0);
  EXPECT_EQ(primitive.at("condensed_patches"), 0);
  EXPECT_NEAR(primitive.at("bits_per_point").get<double>(), 8 * bytes.at("total").get<double>() / points, 1e-9);
  const auto& position = primitive.at("attributes").at(0);
  EXPECT_EQ(position.at("semantic"), "POSITION");
  EXPECT_EQ(position.at("componentType"), 5126);
  EXPECT_EQ(position.at("bits"), 14);

  must_run({"inspect", input});
  EXPECT_TRUE(contains(out_, "POSITION 14 bits"));
}

TEST_F(InspectCommand, SumsUpMorphTargets) {
  must_run({"decode", split_sample(), path("plain.gltf"), "-q"});
  auto asset = read_json("plain.gltf");
  auto& primitive = asset["meshes"][0]["primitives"][0];
  for (int i = 0; i < 2; ++i)
    primitive["targets"].push_back({{"POSITION", primitive["attributes"]["POSITION"]}});
  std::ofstream(path("plain.gltf")) << asset;
  must_run({"encode", path("plain.gltf"), path("morphing.glb"), "--morph-targets", "patches", "-q"});
  must_run({"inspect", path("morphing.glb")});
  EXPECT_TRUE(
      contains(std::regex_replace(out_, std::regex("\\s+"), " "), "2 morph targets of POSITION 15 bits"))
      << out_;
  EXPECT_EQ(json_of({"inspect", path("morphing.glb"), "--format", "json"})
                .at("primitives")
                .at(0)
                .at("attributes")
                .size(),
            3u);
}

TEST_F(InspectCommand, ShowsTheBoxesOfPatches) {
  const std::string plain = split_sample();
  EXPECT_FALSE(json_of({"inspect", plain, "--format", "json"}).at("primitives").at(0).contains("boxes"));
  EXPECT_FALSE(contains(run_command({"inspect", plain}).out, "boxes"));
  for (const std::string condense : {"", "--condense"}) {
    std::vector<std::string> words{"encode", sample(), path("boxes.glb"), "--patches", "4", "--boxes",
                                   "-q",     "-f"};
    if (!condense.empty()) words.push_back(condense);
    must_run(words);
    const auto primitive = json_of({"inspect", path("boxes.glb"), "--format", "json"}).at("primitives").at(0);
    const auto& boxes = primitive.at("boxes");
    EXPECT_EQ(boxes.at("bytes"), 24 + 4 * 6);
    EXPECT_GT(primitive.at("bytes").at("head").get<int>(), 24 + 4 * 6);
    ASSERT_EQ(boxes.at("streams").size(), 4u);
    must_run({"decode", path("boxes.glb"), path("decoded.gltf"), "-q", "-f"});
    const auto decoded = read_json("decoded.gltf");
    const auto position =
        decoded.at("meshes").at(0).at("primitives").at(0).at("attributes").at("POSITION").get<size_t>();
    for (const auto& [bound, name] : {std::pair("low", "min"), std::pair("high", "max")})
      for (size_t axis = 0; axis < 3; ++axis) {
        const double of_all = boxes.at("all").at(bound).at(axis).get<double>();
        EXPECT_FLOAT_EQ(static_cast<float>(of_all),
                        decoded.at("accessors").at(position).at(name).at(axis).get<float>());
        double extreme = boxes.at("streams").at(0).at(bound).at(axis).get<double>();
        for (const auto& box : boxes.at("streams")) {
          const double value = box.at(bound).at(axis).get<double>();
          extreme = name == std::string("min") ? std::min(extreme, value) : std::max(extreme, value);
        }
        EXPECT_EQ(extreme, of_all);
      }
    must_run({"inspect", path("boxes.glb")});
    EXPECT_TRUE(contains(out_, "mesh 0, primitive 0: boxes of 4 streams in 48 bytes, from ")) << out_;
    EXPECT_EQ(contains(out_, " boxes of patches\n"), !condense.empty()) << out_;
  }
}

TEST_F(InspectCommand, APlainAssetHasNoPatches) {
  const auto json = json_of({"inspect", sample(), "--format", "json", "-q"});
  EXPECT_TRUE(json.at("primitives").empty());
  const auto& plain = json.at("others").at(0);
  EXPECT_EQ(plain.at("storage"), "plain");
  const auto split = nlohmann::json::parse(run_command({"inspect", split_sample(), "--format", "json"}).out);
  for (const char* key : {"faces", "points"})
    EXPECT_EQ(plain.at(key), split.at("primitives").at(0).at(key)) << key;
  const CommandOutcome text = run_command({"inspect", sample()});
  EXPECT_TRUE(contains(text.out, "mesh 0, primitive 0: plain, 3,004 faces, 1,585 points\n"));
  write("strip.gltf",
        R"({"asset":{"version":"2.0"},"accessors":[{"componentType":5126,"type":"VEC3","count":9}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5},{"attributes":{"POSITION":0},"mode":1},
                             {"attributes":{"POSITION":0}}]}]})");
  EXPECT_TRUE(contains(run_command({"inspect", path("strip.gltf")}).out,
                       "primitive 0: plain, 7 faces, 9 points\nmesh 0, primitive 1: plain, 0 faces, 9 points\n"
                       "mesh 0, primitive 2: plain, 3 faces, 9 points\n"));
}

TEST_F(InspectCommand, DrawsAPreviewBesideItsTable) {
  const std::string split = split_sample();
  run({"inspect", split, "--preview", path("a.png")});
  if (lacks_library()) GTEST_SKIP() << err_;
  const auto draw = [&](const std::string& input, const char* size, const char* threads) {
    const CommandOutcome outcome =
        run_command({"inspect", input, "--preview", path("a.png"), "--preview-size", size, "-j", threads});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, run_command({"inspect", input}).out);
    EXPECT_TRUE(contains(outcome.err, "a.png: "));
    const std::string png = read_bytes(path("a.png"));
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    return png;
  };
  // In a PNG file, the width and height follow the name of the first chunk.
  const std::string png = draw(split, "300x200", "1");
  EXPECT_EQ(png.substr(12, 12), std::string("IHDR\0\0\x01\x2c\0\0\0\xc8", 12));
  EXPECT_TRUE(draw(split, "300x200", "3") == png);
  EXPECT_EQ(draw(split, "64", "2").substr(16, 8), std::string("\0\0\0\x40\0\0\0\x40", 8));
  // Also plain assets, stock Draco, and files other than glTF.
  for (const std::string& input : {sample(), draco_sample(), stock_sample()}) draw(input, "64", "2");
}

TEST_F(InspectCommand, PreviewsThatCannotBeDrawnOrWrittenSayWhy) {
  const std::string input = split_sample();
  fails(2, {"inspect", input, "--preview", path("no/such/folder/a.png")}, path("no/such/folder/a.png"));
  EXPECT_EQ(out_, "");
  write("empty.gltf", R"({"asset": {"version": "2.0"}})");
  fails(5, {"inspect", path("empty.gltf"), "--preview", path("a.png")}, "empty.gltf: nothing to draw: ");
  std::string bytes = read_bytes(input);
  bytes[bytes.rfind("DRACO")] = 'X';
  write("damaged.glb", bytes);
  fails(3, {"inspect", path("damaged.glb"), "--preview", path("a.png")},
        "damaged.glb: mesh 0, primitive 0, patch 3: ");
  EXPECT_FALSE(std::filesystem::exists(path("a.png")));
}

TEST_F(InspectCommand, ShowsAStockDracoStreamAsOnePatch) {
  const std::string drc = draco_sample(), stock = path("stock.gltf");
  must_run({"decode", drc, path("plain.gltf"), "-q"});
  const auto plain = read_json("plain.gltf");
  const auto& accessors = plain.at("accessors");
  const auto& geometry = plain.at("meshes").at(0).at("primitives").at(0);
  const auto count_of = [&](const nlohmann::json& accessor) {
    return accessors.at(accessor.get<size_t>()).at("count").get<int>();
  };
  for (const std::string& input : {drc, stock}) {
    must_run({"inspect", input, "--format", "json"});
    EXPECT_FALSE(contains(err_, "warning"));
    const auto json = nlohmann::json::parse(out_);
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
                                                     {"head", 0},
                                                     {"stitch", 0},
                                                     {"total", std::filesystem::file_size(drc)}}));
    EXPECT_NEAR(primitive.at("bits_per_point").get<double>(),
                8 * static_cast<double>(std::filesystem::file_size(drc)) / primitive.at("points").get<double>(),
                1e-9);
    ASSERT_EQ(primitive.at("attributes").size(), 1u);
    EXPECT_EQ(primitive.at("attributes").at(0),
              nlohmann::json({{"semantic", "POSITION"}, {"componentType", 5126}, {"bits", 14}}));
    must_run({"inspect", input});
    EXPECT_TRUE(contains(out_, "POSITION 14 bits"));
    EXPECT_TRUE(contains(out_, "edgebreaker"));
  }
  EXPECT_EQ(run_command_on(drc, {"inspect", "-"}).out, run_command({"inspect", drc}).out);
  if (!has_draco()) return;
  for (const std::string& input : {drc, stock, split_sample()})
    EXPECT_EQ(run_command({"inspect", input, "--backend", "cpu"}).out,
              run_command({"inspect", input, "--backend", "draco"}).out);
}

TEST_F(InspectCommand, TellsCodingsAndStoragesApart) {
  const auto first_of = [&](const std::string& input) {
    return json_of({"inspect", input, "--format", "json"}).at("primitives").at(0);
  };
  const auto split = first_of(split_sample());
  EXPECT_EQ(split.at("storage"), "patches");
  EXPECT_EQ(split.at("coding"), "edgebreaker");
  const std::string out = path("valence.glb");
  must_run({"decode", path("terrain.glb"), out, "--to", "draco", "--encode-speed", "0", "-q"});
  EXPECT_EQ(first_of(out).at("coding"), "edgebreaker-valence");
  // All faces are degenerate, which Edgebreaker cannot encode.
  Mesh flat;
  flat.point_count = 2;
  flat.faces = {{0, 0, 1}, {1, 1, 0}};
  flat.attributes.push_back({"POSITION", ComponentType::kFloat32, 3, false, Array<std::byte>(24)});
  const StockStream stream = must(encode_stock_stream(flat, std::vector<AttributeCoding>(1), 5));
  write("flat.drc", std::string(stream.bytes.begin(), stream.bytes.end()));
  EXPECT_EQ(first_of(path("flat.drc")).at("coding"), "sequential");
}

TEST_F(InspectCommand, NamesTheBrokenStream) {
  std::string bytes = read_bytes(draco_sample());
  write("short.drc", bytes.substr(0, bytes.size() - 20));
  EXPECT_EQ(run({"inspect", path("short.drc")}), 3) << err_;
  EXPECT_EQ(out_, "");
  EXPECT_TRUE(contains(err_, "short.drc: Draco stream: "));
  std::string binary = read_bytes(path(binary_of("stock.gltf")));
  binary[binary.find("DRACO")] = 'X';
  write(binary_of("stock.gltf"), binary);
  fails(3, {"inspect", path("stock.gltf")}, "stock.gltf: mesh 0, primitive 0: Draco stream: not a Draco mesh");
}

}  // namespace
}  // namespace psplit
