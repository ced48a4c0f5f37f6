// The one line that each subcommand logs, the same in JSON, and errors.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

class SummaryOfFiles : public CommandTest {
 protected:
  std::string plain() const {
    const CommandOutcome outcome = run_command({"generate", path("plain.glb"), "--faces", "4k"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, as_bytes(std::filesystem::file_size(path("plain.glb"))) + ", terrain, "))
        << outcome.err;
    return path("plain.glb");
  }
  static nlohmann::json parse_file(const std::string& name) {
    return nlohmann::json::parse(std::ifstream(name, std::ios::binary));
  }
};

TEST_F(SummaryOfFiles, EncodeAndDecodeSayBytesInAndOut) {
  const std::string input = plain(), split = path("split.glb"), back = path("back.gltf");
  const auto size = [](const std::string& file) { return std::filesystem::file_size(file); };
  const CommandOutcome encoded =
      run_command({"encode", input, split, "--patches", "4", "--report", path("encode.json")});
  ASSERT_EQ(encoded.code, 0) << encoded.err;
  EXPECT_TRUE(contains(encoded.err, split + ": " + as_bytes(size(split)) + " from " + as_bytes(size(input))))
      << encoded.err;
  EXPECT_TRUE(contains(encoded.err, " in 4 patches; ")) << encoded.err;
  const auto report = parse_file(path("encode.json")).at("files");
  EXPECT_EQ(report.at("input").at("bytes"), size(input));
  EXPECT_EQ(report.at("output").at("bytes"), size(split));
  EXPECT_EQ(report.at("output").at("texture_bytes"), 0);
  EXPECT_DOUBLE_EQ(report.at("ratio"), static_cast<double>(size(split)) / static_cast<double>(size(input)));

  const CommandOutcome decoded = run_command({"decode", split, back, "--report", path("decode.json")});
  ASSERT_EQ(decoded.code, 0) << decoded.err;
  const std::string binary = path(parse_file(back).at("buffers").at(0).at("uri"));
  EXPECT_TRUE(contains(decoded.err, as_bytes(size(back) + size(binary)) + " from ")) << decoded.err;
  EXPECT_TRUE(contains(decoded.err, "; 1 primitive decoded; ")) << decoded.err;
  const auto decode_report = parse_file(path("decode.json"));
  EXPECT_EQ(decode_report.at("decoded"), 1);
  EXPECT_EQ(decode_report.at("files").at("output").at("bytes"), size(back) + size(binary));
}

TEST_F(SummaryOfFiles, TexturesCountWhereverTheyAre) {
  // One image is beside the asset, one embedded, one in the JSON, and one missing.
  std::ofstream(path("a.png"), std::ios::binary) << std::string(1000, 'p');
  const std::string data_uri = "data:image/png;base64,AAAA";
  std::ofstream(path("asset.gltf")) << R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":40,
    "uri":"data:application/octet-stream;base64,)"
                                    << std::string(52, 'A') << R"(AA=="}],
    "bufferViews":[{"buffer":0,"byteLength":40}],
    "images":[{"uri":"a.png"},{"bufferView":0,"mimeType":"image/png"},{"uri":"a.png"},{"uri":"none.png"},
              {"uri":")" << data_uri << R"("}]})";
  const AssetBytes bytes = bytes_on_disk(path("asset.gltf"));
  EXPECT_EQ(bytes.files, std::filesystem::file_size(path("asset.gltf")) + 1000);
  EXPECT_EQ(bytes.textures, 1000 + 40 + data_uri.size());
  // A mesh file has no other files, and the size of a pipe is unknown.
  std::ofstream(path("mesh.obj")) << "v 0 0 0\n";
  EXPECT_EQ(bytes_on_disk(path("mesh.obj")).files, 8u);
  EXPECT_EQ(bytes_on_disk("-").files, 0u);
  EXPECT_EQ(bytes_on_disk("/dev/null").files, 0u);
  EXPECT_EQ(bytes_on_disk(path("none.glb")).files, 0u);
}

TEST_F(SummaryOfFiles, MaterialsAndImagesOfAnObjCount) {
  std::ofstream(path("a.png"), std::ios::binary) << std::string(1000, 'p');
  std::ofstream(path("a.mtl")) << "newmtl m\nmap_Kd a.png\n";
  std::ofstream(path("a.obj")) << "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
  const uint64_t bytes =
      std::filesystem::file_size(path("a.obj")) + std::filesystem::file_size(path("a.mtl")) + 1000;
  for (const char* verb : {"encode", "decode"}) {
    const CommandOutcome outcome =
        run_command({verb, path("a.obj"), path("a.glb"), "-q", "--report", path("report.json")});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto input = parse_file(path("report.json")).at("files").at("input");
    EXPECT_EQ(input.at("bytes"), bytes) << verb;
    EXPECT_EQ(input.at("texture_bytes"), 1000) << verb;
  }
}

TEST_F(SummaryOfFiles, WhereNothingWasDoneThatIsSaid) {
  std::ofstream(path("empty.gltf")) << R"({"asset":{"version":"2.0"}})";
  const CommandOutcome encoded = run_command({"encode", path("empty.gltf"), path("a.glb")});
  EXPECT_EQ(encoded.code, 0) << encoded.err;
  EXPECT_TRUE(contains(encoded.err, "nothing was encoded")) << encoded.err;
  const CommandOutcome decoded = run_command({"decode", plain(), path("a.glb")});
  EXPECT_EQ(decoded.code, 0) << decoded.err;
  EXPECT_TRUE(contains(decoded.err, "nothing was decoded: no primitive is compressed")) << decoded.err;
}

TEST_F(SummaryOfFiles, OutputsAreCheckedBeforeTheWork) {
  const std::string input = plain(), missing = path("no/such/folder/a");
  const auto fails = [&](const std::vector<std::string>& words, const std::string& why) {
    const CommandOutcome outcome = run_command(words);
    EXPECT_EQ(outcome.code, 2) << words[0];
    EXPECT_TRUE(contains(outcome.err, why)) << outcome.err;
    // There is only the error, because the work has not begun.
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  };
  const std::string folder = ": there is no folder " + path("no/such/folder");
  // The input is missing too. The error would name it if the output were checked later.
  fails({"encode", path("none.glb"), missing + ".glb"}, missing + ".glb" + folder);
  fails({"encode", path("none.glb"), path("a.glb"), "--report", missing}, missing + folder);
  fails({"decode", path("none.glb"), missing + ".gltf"}, missing + ".gltf" + folder);
  fails({"decode", path("none.glb"), path("a.glb"), "--report", missing}, missing + folder);
  fails({"compare", path("none.glb"), "-o", missing}, missing + folder);
  fails({"generate", missing + ".glb"}, missing + ".glb" + folder);
  fails({"inspect", path("none.glb"), "--preview", missing + ".png"}, missing + ".png" + folder);
  fails({"inspect", path("none.glb"), "-o", missing}, missing + folder);
  fails({"validate", path("none.glb"), "-o", missing}, missing + folder);
  std::filesystem::create_directory(path("taken.glb"));
  fails({"generate", path("taken.glb")}, "taken.glb: is a folder");
  fails({"generate", input + "/a.glb"}, "plain.glb is not a folder");
  EXPECT_EQ(run_command({"generate", "/dev/null", "--faces", "1k"}).code, 1);  // not a .glb
}

TEST_F(SummaryOfFiles, ErrorsNameAPathOnce) {
  const auto names_once = [&](const std::vector<std::string>& words, const std::string& name) {
    const CommandOutcome outcome = run_command(words);
    EXPECT_NE(outcome.code, 0) << words[0];
    const size_t first = outcome.err.find(name);
    ASSERT_NE(first, std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find(name, first + 1), std::string::npos) << outcome.err;
  };
  for (const std::string name : {"none.glb", "none.ply", "none.drc"}) {
    const std::string out = path("a.glb");
    names_once({"encode", path(name), out}, name);
    names_once({"decode", path(name), out}, name);
    names_once({"inspect", path(name)}, name);
    names_once({"validate", path(name)}, name);
    names_once({"compare", path(name)}, name);
  }
  std::filesystem::create_directory(path("folder.glb"));
  names_once({"inspect", path("folder.glb")}, "folder.glb");
  names_once({"generate", path("folder.glb")}, "folder.glb");
  std::ofstream(path("broken.glb")) << "glTF";
  names_once({"encode", path("broken.glb"), path("a.glb")}, "broken.glb");
}

}  // namespace
}  // namespace psplit
