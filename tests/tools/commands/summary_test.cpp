// The one line that each subcommand logs, the same in JSON, and errors.
#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

class SummaryOfFiles : public CommandTest {
 protected:
  std::string plain() {
    must_run({"generate", path("plain.glb"), "--faces", "4k"});
    EXPECT_TRUE(contains(err_, as_bytes(std::filesystem::file_size(path("plain.glb"))) + ", terrain, "));
    return path("plain.glb");
  }
};

TEST_F(SummaryOfFiles, EncodeAndDecodeSayBytesInAndOut) {
  const std::string input = plain(), split = path("split.glb"), back = path("back.gltf");
  const auto size = [](const std::string& file) { return std::filesystem::file_size(file); };
  must_run({"encode", input, split, "--patches", "4", "--report", path("encode.json")});
  EXPECT_TRUE(contains(err_, split + ": " + as_bytes(size(split)) + " from " + as_bytes(size(input))));
  EXPECT_TRUE(contains(err_, " in 4 patches; "));
  const auto report = read_json("encode.json").at("files");
  EXPECT_EQ(report.at("input").at("bytes"), size(input));
  EXPECT_EQ(report.at("output").at("bytes"), size(split));
  EXPECT_EQ(report.at("output").at("texture_bytes"), 0);
  EXPECT_DOUBLE_EQ(report.at("ratio"), static_cast<double>(size(split)) / static_cast<double>(size(input)));

  must_run({"decode", split, back, "--report", path("decode.json")});
  const std::string binary = path(read_json("back.gltf").at("buffers").at(0).at("uri"));
  EXPECT_TRUE(contains(err_, as_bytes(size(back) + size(binary)) + " from "));
  EXPECT_TRUE(contains(err_, "; 1 primitive decoded; "));
  const auto decode_report = read_json("decode.json");
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
    must_run({verb, path("a.obj"), path("a.glb"), "-q", "--report", path("report.json")});
    const auto input = read_json("report.json").at("files").at("input");
    EXPECT_EQ(input.at("bytes"), bytes) << verb;
    EXPECT_EQ(input.at("texture_bytes"), 1000) << verb;
  }
}

TEST_F(SummaryOfFiles, WhereNothingWasDoneThatIsSaid) {
  std::ofstream(path("empty.gltf")) << R"({"asset":{"version":"2.0"}})";
  must_run({"encode", path("empty.gltf"), path("a.glb")});
  EXPECT_TRUE(contains(err_, "nothing was encoded"));
  must_run({"decode", plain(), path("a.glb")});
  EXPECT_TRUE(contains(err_, "nothing was decoded: no primitive is compressed"));
}

TEST_F(SummaryOfFiles, OutputsAreCheckedBeforeTheWork) {
  const std::string input = plain(), missing = path("no/such/folder/a");
  const auto fails_at_once = [&](const std::vector<std::string>& words, const std::string& why) {
    fails(2, words, why);
    // There is only the error, because the work has not begun.
    EXPECT_EQ(std::ranges::count(err_, '\n'), 1) << err_;
  };
  const std::string folder = ": there is no folder " + path("no/such/folder");
  // The input is missing too. The error would name it if the output were checked later.
  fails_at_once({"encode", path("none.glb"), missing + ".glb"}, missing + ".glb" + folder);
  fails_at_once({"encode", path("none.glb"), path("a.glb"), "--report", missing}, missing + folder);
  fails_at_once({"decode", path("none.glb"), missing + ".gltf"}, missing + ".gltf" + folder);
  fails_at_once({"decode", path("none.glb"), path("a.glb"), "--report", missing}, missing + folder);
  fails_at_once({"compare", path("none.glb"), "-o", missing}, missing + folder);
  fails_at_once({"diff", path("none.glb"), input, "-o", missing}, missing + folder);
  fails_at_once({"generate", missing + ".glb"}, missing + ".glb" + folder);
  fails_at_once({"inspect", path("none.glb"), "--preview", missing + ".png"}, missing + ".png" + folder);
  fails_at_once({"inspect", path("none.glb"), "-o", missing}, missing + folder);
  fails_at_once({"validate", path("none.glb"), "-o", missing}, missing + folder);
  std::filesystem::create_directory(path("taken.glb"));
  fails_at_once({"generate", path("taken.glb")}, "taken.glb: is a folder");
  fails_at_once({"generate", input + "/a.glb"}, "plain.glb is not a folder");
  EXPECT_EQ(run_command({"generate", "/dev/null", "--faces", "1k"}).code, 1);  // not a .glb
}

TEST_F(SummaryOfFiles, ErrorsNameAPathOnce) {
  const auto names_once = [&](const std::vector<std::string>& words, const std::string& name) {
    EXPECT_NE(run(words), 0) << words[0];
    const size_t first = err_.find(name);
    ASSERT_NE(first, std::string::npos) << err_;
    EXPECT_EQ(err_.find(name, first + 1), std::string::npos);
  };
  for (const std::string name : {"none.glb", "none.ply", "none.drc"}) {
    const std::string out = path("a.glb");
    names_once({"encode", path(name), out}, name);
    names_once({"decode", path(name), out}, name);
    names_once({"inspect", path(name)}, name);
    names_once({"validate", path(name)}, name);
    if (has_draco()) names_once({"compare", path(name)}, name);
    names_once({"diff", path(name), path("b.glb")}, name);
  }
  std::filesystem::create_directory(path("folder.glb"));
  names_once({"inspect", path("folder.glb")}, "folder.glb");
  names_once({"generate", path("folder.glb")}, "folder.glb");
  std::ofstream(path("broken.glb")) << "glTF";
  names_once({"encode", path("broken.glb"), path("a.glb")}, "broken.glb");
}

}  // namespace
}  // namespace psplit
