// gltf-psplit encode --condense and expand.
#include <cstring>

#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class ExpandCommand : public CommandOnSamples {
 protected:
  // condensed.glb: the terrain of split_sample, condensed.
  std::string condensed_sample(const std::string& patches = "4") {
    must_run({"encode", sample("terrain", "20000"), path("condensed.glb"), "--patches", patches, "--condense",
              "-q"});
    return path("condensed.glb");
  }
  nlohmann::json inspect(const std::string& file) {
    return json_of({"inspect", file, "--format", "json", "-q"}).at("primitives").at(0);
  }
};

TEST_F(ExpandCommand, RestoresThePatches) {
  const std::string condensed = condensed_sample();
  must_run({"encode", path("terrain.glb"), path("split.glb"), "--patches", "4", "-q"});
  must_run({"expand", condensed, path("expanded.glb"), "--report", path("report.json")});
  EXPECT_TRUE(contains(err_, "1 primitive expanded to Draco patches"));
  const auto report = read_json("report.json");
  EXPECT_EQ(report.at("expanded_to_patches"), 1);
  EXPECT_EQ(report.at("expanded_to_draco"), 0);
  const auto before = inspect(condensed), after = inspect(path("expanded.glb")),
             split = inspect(path("split.glb"));
  EXPECT_GT(before.at("condensed_patches"), 0);
  EXPECT_EQ(before.at("condensed_patches"), 4);
  EXPECT_GT(before.at("bytes").at("head"), 0);
  EXPECT_EQ(report.at("streams").at("input_bytes"), before.at("bytes").at("total"));
  EXPECT_EQ(report.at("streams").at("output_bytes"), split.at("bytes").at("total"));
  EXPECT_EQ(after, split);
  EXPECT_LT(before.at("bytes").at("total"), split.at("bytes").at("total"));
}

// Whatever is condensed comes back as the file that it would have been.
TEST_F(ExpandCommand, GivesTheFileOfNoCondense) {
  const auto run_quietly = [&](std::vector<std::string> words) {
    words.push_back("-q");
    must_run(words);
  };
  run_quietly({"generate", path("sheet.glb"), "--faces", "3000", "--normals", "--texcoords"});
  run_quietly({"generate", path("scene.glb"), "--shape", "scene", "--faces", "6000"});
  run_quietly({"encode", path("sheet.glb"), path("stock.glb"), "--compat", "khr"});
  for (const std::string name : {"sheet", "scene", "stock"})
    for (const char* patches : {"0", "1", "3"}) {
      std::vector<std::string> options{"encode", path(name + ".glb"), path("plain.glb")};
      if (*patches != '0') options.insert(options.end(), {"--patches", patches});
      run_quietly(options);
      options[2] = path("condensed.glb");
      options.push_back("--condense");
      run_quietly(options);
      run_quietly({"expand", path("condensed.glb"), path("expanded.glb")});
      const std::string before = read_bytes(path("plain.glb"));
      EXPECT_TRUE(read_bytes(path("condensed.glb")) != before) << name << patches;
      EXPECT_TRUE(read_bytes(path("expanded.glb")) == before) << name << patches;
    }
}

// The names of extensions keep their order, wherever that of Draco stood.
TEST_F(ExpandCommand, ExtensionsOfAnInputWithStockDracoKeepTheirOrder) {
  must_run({"generate", path("scene.glb"), "--shape", "scene", "--faces", "6000", "-q"});
  must_run({"encode", path("scene.glb"), path("stock.gltf"), "--compat", "khr", "-q"});
  nlohmann::json asset = nlohmann::json::parse(read_bytes(path("stock.gltf")));
  asset["extensionsUsed"] = {"KHR_draco_mesh_compression", "KHR_materials_unlit"};
  std::ofstream(path("stock.gltf"), std::ios::binary) << asset.dump();
  for (const char* patches : {"0", "1", "3"}) {
    std::vector<std::string> options{"encode", path("stock.gltf"), path("plain.glb"), "-q", "--force"};
    if (*patches != '0') options.insert(options.end(), {"--patches", patches});
    must_run(options);
    options[2] = path("condensed.glb");
    options.push_back("--condense");
    must_run(options);
    must_run({"expand", path("condensed.glb"), path("expanded.glb"), "-q", "--force"});
    const auto names = [&](const char* file) {
      constexpr size_t kLengthAt = 12, kJsonAt = 20;
      const std::string glb = read_bytes(path(file));
      uint32_t length = 0;
      std::memcpy(&length, glb.data() + kLengthAt, sizeof length);
      return nlohmann::json::parse(glb.substr(kJsonAt, length)).at("extensionsUsed");
    };
    EXPECT_EQ(names("expanded.glb"), names("plain.glb")) << patches;
    // Without a wish for patches the asset stays as it is, because it would grow.
    if (*patches != '0') {
      EXPECT_TRUE(read_bytes(path("expanded.glb")) == read_bytes(path("plain.glb"))) << patches;
    }
  }
}

TEST_F(ExpandCommand, PatchesOfTheInputAreCondensedAndComeBack) {
  const std::string split = split_sample();
  must_run({"encode", split, path("small.glb"), "--condense", "--report", path("report.json"), "-j", "2"});
  EXPECT_TRUE(contains(err_, "1 primitive condensed without encoding again"));
  const auto report = read_json("report.json");
  EXPECT_EQ(report.at("primitives").at(0).at("keeps_streams"), true);
  EXPECT_LT(report.at("geometry").at("output_bytes"), report.at("geometry").at("input_bytes"));
  EXPECT_EQ(inspect(path("small.glb")).at("condensed_patches"), 4);
  must_run({"expand", path("small.glb"), path("back.glb"), "-q"});
  EXPECT_EQ(inspect(path("back.glb")), inspect(split));
}

TEST_F(ExpandCommand, MakesStockDracoOfASinglePatch) {
  const std::string condensed = condensed_sample("1");
  must_run({"expand", condensed, path("expanded.gltf"), "-j", "2"});
  EXPECT_TRUE(contains(err_, "1 primitive to stock Draco"));
  EXPECT_EQ(inspect(path("expanded.gltf")).at("storage"), "draco");
  EXPECT_FALSE(contains(read_bytes(path("expanded.gltf")), "PSPLIT_mesh_draco_patches"));
}

TEST_F(ExpandCommand, PassesOnWhatIsNotCondensed) {
  const std::string split = split_sample();
  must_run({"expand", split, path("out.glb")});
  EXPECT_TRUE(contains(err_, "nothing was expanded: no primitive is condensed"));
  EXPECT_EQ(read_bytes(path("out.glb")), read_bytes(split));
}

TEST_F(ExpandCommand, SaysWhatIsWrongWithABrokenContainer) {
  const std::string condensed = condensed_sample();
  std::string bytes = read_bytes(condensed);
  bytes[bytes.rfind("PSPL\x01") + 5] = 4;  // an unknown flag
  write("broken.glb", bytes);
  for (const char* verb : {"expand", "decode"}) {
    fails(5, {verb, path("broken.glb"), path("out.glb")},
          "broken.glb: mesh 0, primitive 0: container: a flag that is not known");
    EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
  }
}

TEST_F(ExpandCommand, InspectTellsWhereTheBytesAre) {
  const std::string condensed = condensed_sample();
  must_run({"inspect", condensed});
  EXPECT_TRUE(contains(out_, "patches (condensed)"));
  EXPECT_TRUE(contains(out_, "mesh 0, primitive 0: 4 of 4 patches condensed\n"));
  for (const char* row :
       {"directory\n", "head\n", "stitch map\n", "connectivity: symbols\n", "POSITION: tokens\n"})
    EXPECT_TRUE(contains(out_, row)) << row << out_;

  const auto primitive = inspect(condensed);
  const auto& bytes = primitive.at("bytes");
  const auto& sections = primitive.at("sections");
  uint64_t sum = 0;
  for (const char* name : {"directory", "head", "stitch"}) sum += bytes.at(name).get<uint64_t>();
  for (const char* name : {"numbers", "borders", "symbols", "seams", "ends", "stored_streams"})
    sum += sections.at(name).get<uint64_t>();
  for (const auto& attribute : sections.at("attributes"))
    for (const char* name : {"tokens", "bits", "flags"}) sum += attribute.at(name).get<uint64_t>();
  EXPECT_EQ(sum, bytes.at("total"));
  EXPECT_EQ(sections.at("attributes").at(0).at("semantic"), "POSITION");
  EXPECT_GT(sections.at("attributes").at(0).at("tokens"), sections.at("symbols"));
  // About 0.7 bits for each of the triangles, and a few bytes for the ends of each patch's sections.
  EXPECT_GT(sections.at("symbols"), 500);
  EXPECT_LT(sections.at("ends"), 4 * 16 * sections.at("attributes").size());
  EXPECT_EQ(sections.at("stored_streams"), 0);
  EXPECT_FALSE(inspect(split_sample()).contains("sections"));
}

TEST_F(ExpandCommand, CondensingIsChosenByFlags) {
  const std::string input = sample("terrain", "20000");
  const auto encoded = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"encode", input, path("out.glb"), "--patches", "4", "-q"});
    must_run(options);
    return read_bytes(path("out.glb"));
  };
  EXPECT_EQ(encoded({}), encoded({"--no-condense"}));
  EXPECT_LT(encoded({"--condense"}).size(), encoded({}).size());
  EXPECT_LE(encoded({"--condense", "--profile", "size"}).size(), encoded({"--condense"}).size());
  fails(1, {"encode", input, path("out.glb"), "--condense", "--no-condense"},
        "--condense excludes --no-condense");
}

TEST_F(ExpandCommand, TheProfileForSizeChoosesByBytes) {
  const std::string input = sample("terrain", "20000");
  const auto encoded = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"encode", input, path("out.glb"), "--profile", "size", "-q"});
    must_run(options);
    return read_bytes(path("out.glb"));
  };
  const auto by_speed = encoded({"--encode-speed", "5"}), by_bytes = encoded({});
  EXPECT_LT(by_bytes.size(), by_speed.size());
  // libdraco chooses by speed alone.
  if (has_draco()) {
    EXPECT_EQ(encoded({"--encoder", "draco"}), by_speed);
  }
  const auto condensed = encoded({"--condense"});
  EXPECT_LT(condensed.size(), by_bytes.size());
  EXPECT_LE(condensed.size(), encoded({"--condense", "--encode-speed", "5"}).size());
  // The condensed streams are Draco streams of the same mesh.
  encoded({"--condense"});
  must_run({"expand", path("out.glb"), path("expanded.glb"), "-q"});
  must_run({"diff", path("out.glb"), path("expanded.glb"), "-q"});
  must_run({"validate", path("expanded.glb"), "-q"});
}

}  // namespace
}  // namespace psplit
