// gltf-psplit encode --skip: attributes that are left out.

#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

// asset.gltf: a grid of 8 by 8 squares with two sets of texture coordinates, of which a material reads the
// first.
class EncodeSkip : public CommandOnSamples {
 protected:
  static constexpr uint32_t kSide = 9, kPoints = kSide * kSide, kIndices = (kSide - 1) * (kSide - 1) * 6;

  nlohmann::json asset() const {
    std::string bytes;
    const auto add = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
    const auto add_points = [&](int components) {
      for (uint32_t i = 0; i < kPoints; ++i)
        for (int c = 0; c < components; ++c)
          add(c == 0   ? static_cast<float>(i % kSide) / kSide
              : c == 1 ? static_cast<float>(i / kSide) / kSide
                       : 0.25f);
    };
    add_points(3);
    add_points(2);
    add_points(2);
    for (uint16_t y = 0; y + 1u < kSide; ++y)
      for (uint16_t x = 0; x + 1u < kSide; ++x) {
        const auto corner = static_cast<uint16_t>(y * kSide + x);
        for (const uint32_t to : {0u, 1u, kSide, kSide, 1u, kSide + 1}) add(static_cast<uint16_t>(corner + to));
      }
    write("asset.bin", bytes);
    nlohmann::json json = nlohmann::json::parse(R"({"asset":{"version":"2.0"},
      "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
      "textures":[{}],"meshes":[{"primitives":[{"material":0,"indices":3,
        "attributes":{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2}}]}]})");
    json["buffers"] = {{{"uri", "asset.bin"}, {"byteLength", bytes.size()}}};
    size_t offset = 0;
    for (const int components : {3, 2, 2, 1}) {
      const bool is_index = components == 1;
      const size_t length = is_index ? kIndices * 2 : kPoints * 4 * static_cast<size_t>(components);
      json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}});
      json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                   {"componentType", is_index ? 5123 : 5126},
                                   {"count", is_index ? kIndices : kPoints},
                                   {"type", is_index ? "SCALAR" : "VEC" + std::to_string(components)}});
      offset += length;
    }
    json["accessors"][0]["min"] = {0, 0, 0.25};
    json["accessors"][0]["max"] = {8.0 / 9, 8.0 / 9, 0.25};
    return json;
  }
  nlohmann::json& primitive(nlohmann::json& json) const { return json["meshes"][0]["primitives"][0]; }

  int encode(const nlohmann::json& json, const std::string& output, std::vector<std::string> options) {
    write("asset.gltf", json.dump());
    options.insert(options.begin(), {"encode", path("asset.gltf"), path(output)});
    return run(std::move(options));
  }
};

TEST_F(EncodeSkip, LeavesAttributesOutAndCountsThem) {
  ASSERT_EQ(encode(asset(), "all.gltf", {"-q"}), 0) << err_;
  ASSERT_EQ(
      encode(asset(), "out.gltf", {"--skip", "TEXCOORD_1", "--skip", "COLOR_0", "--report", path("r.json")}), 0)
      << err_;
  EXPECT_TRUE(contains(err_, "left out TEXCOORD_1 of 1 primitive"));
  EXPECT_TRUE(contains(err_, "warning: " + path("asset.gltf") + ": no primitive has COLOR_0"));
  const nlohmann::json report = read_json("r.json"), out = read_json("out.gltf");
  EXPECT_EQ(report["dropped_attributes"], nlohmann::json::parse(R"({"COLOR_0":0,"TEXCOORD_1":1})"));
  EXPECT_EQ(report["primitives"][0]["dropped_attributes"], nlohmann::json::parse(R"(["TEXCOORD_1"])"));
  const nlohmann::json& primitive = out["meshes"][0]["primitives"][0];
  EXPECT_FALSE(primitive["attributes"].contains("TEXCOORD_1"));
  EXPECT_TRUE(primitive["attributes"].contains("TEXCOORD_0"));
  EXPECT_EQ(primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"].size(), 2u);
  EXPECT_EQ(out["accessors"].size(), 3u);
  EXPECT_LT(out["buffers"][0]["byteLength"], read_json("all.gltf")["buffers"][0]["byteLength"]);
  must_run({"validate", path("out.gltf"), "-q"});
  EXPECT_EQ(run({"diff", path("asset.gltf"), path("out.gltf")}), 7);
  EXPECT_TRUE(contains(out_, "TEXCOORD_1"));
  // Skips in a primitive that stays as it was, too, and without a material all coordinates.
  nlohmann::json json = asset();
  this->primitive(json).erase("material");
  this->primitive(json)["mode"] = 0;
  ASSERT_EQ(encode(json, "plain.gltf", {"--skip", "TEXCOORD_0", "--skip", "TEXCOORD_1"}), 0) << err_;
  EXPECT_EQ(read_json("plain.gltf")["accessors"].size(), 2u);
  EXPECT_TRUE(contains(err_, "left out TEXCOORD_0 of 1 primitive; left out TEXCOORD_1 of 1 primitive"));
}

TEST_F(EncodeSkip, EncodesStockDracoAgain) {
  ASSERT_EQ(encode(asset(), "out.gltf", {"-q", "--quantize-texcoord", "20"}), 0) << err_;
  const auto bytes = [&] { return read_json("again.gltf")["buffers"][0]["byteLength"].get<int>(); };
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {"--condense"}, {"--patches", "2"}}) {
    std::vector<std::string> words = {"encode", path("out.gltf"), path("again.gltf"), "--quantize-texcoord",
                                      "20"};
    words.insert(words.end(), more.begin(), more.end());
    must_run(words);
    const int before = bytes();
    words.insert(words.end(), {"--skip", "TEXCOORD_1"});
    must_run(words);
    EXPECT_TRUE(contains(err_, "left out TEXCOORD_1"));
    EXPECT_LT(bytes(), before - 20);
    must_run({"validate", path("again.gltf"), "-q"});
  }
  // Patches stay as they are.
  fails(1, {"encode", path("again.gltf"), path("c.glb"), "--skip", "TEXCOORD_0"},
        "TEXCOORD_0 cannot be skipped: it is in patches");
}

TEST_F(EncodeSkip, RefusesWhatTheAssetNeeds) {
  const auto refuses = [&](const nlohmann::json& json, const std::string& attribute,
                           const std::string& reason) {
    EXPECT_EQ(encode(json, "out.gltf", {"--skip", attribute}), 1) << attribute;
    EXPECT_TRUE(contains(err_, "mesh 0, primitive 0: " + attribute + " cannot be skipped: " + reason));
    EXPECT_FALSE(std::filesystem::exists(path("out.gltf")));
  };
  refuses(asset(), "POSITION", "a mesh needs positions");
  refuses(asset(), "TEXCOORD_0", "TEXCOORD_1 would stay without it");
  nlohmann::json json = asset();
  nlohmann::json& texture = json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  texture["texCoord"] = 1;
  refuses(json, "TEXCOORD_1", "material 0 has a texture");
  texture["texCoord"] = 0;
  texture["extensions"]["KHR_texture_transform"]["texCoord"] = 1;
  refuses(json, "TEXCOORD_1", "material 0 has a texture");
  json = asset();
  json["materials"].push_back({{"extensions", {{"KHR_x", {{"t", {{"index", 0}, {"texCoord", 1}}}}}}}});
  primitive(json)["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {0}}}};
  refuses(json, "TEXCOORD_1", "material 1 has a texture");
  json = asset();
  primitive(json)["attributes"]["_FEATURE_ID_0"] = 2;
  primitive(json)["extensions"]["EXT_mesh_features"]["featureIds"] = {{{"featureCount", 1}, {"attribute", 0}}};
  refuses(json, "_FEATURE_ID_0", "EXT_mesh_features");
  json = asset();
  primitive(json)["targets"] = {{{"TEXCOORD_1", 2}}};
  refuses(json, "TEXCOORD_1", "a morph target would be empty");
  json = asset();
  json["accessors"].push_back(
      {{"componentType", 5121}, {"normalized", true}, {"count", kPoints}, {"type", "VEC4"}});
  primitive(json)["attributes"]["WEIGHTS_0"] = 4;
  json["accessors"].push_back({{"componentType", 5121}, {"count", kPoints}, {"type", "VEC4"}});
  primitive(json)["attributes"]["JOINTS_0"] = 5;
  refuses(json, "JOINTS_0", "WEIGHTS_0 would stay");
}

TEST_F(EncodeSkip, LeavesOutWhatNothingReads) {
  // The names of the attributes that --skip unused leaves.
  const auto kept = [&](nlohmann::json json, const std::string& attribute = "") {
    if (!attribute.empty()) primitive(json)["attributes"][attribute] = 2;
    EXPECT_EQ(encode(json, "out.gltf", {"--skip", "unused", "-f"}), 0) << err_;
    EXPECT_FALSE(contains(err_, "which is to be skipped"));
    nlohmann::json out = read_json("out.gltf");
    std::vector<std::string> names;
    for (const auto& [name, index] : primitive(out)["attributes"].items()) names.push_back(name);
    return names;
  };
  using Names = std::vector<std::string>;
  const std::string advice = "nothing reads TEXCOORD_1 of 1 primitive; --skip unused leaves out";
  ASSERT_EQ(encode(asset(), "all.gltf", {"--report", path("r.json")}), 0) << err_;
  EXPECT_TRUE(contains(err_, advice)) << err_;
  EXPECT_EQ(read_json("r.json")["unused_attributes"], nlohmann::json::parse(R"({"TEXCOORD_1":1})"));
  EXPECT_EQ(kept(asset()), (Names{"POSITION", "TEXCOORD_0"}));
  EXPECT_TRUE(contains(err_, "left out TEXCOORD_1 of 1 primitive"));
  EXPECT_FALSE(contains(err_, advice));
  // A Draco stream that stays as it is, here because all faces are degenerate, keeps what it has.
  nlohmann::json degenerate = asset();
  degenerate["accessors"][3].erase("bufferView");
  ASSERT_EQ(encode(degenerate, "kept.gltf", {"--keep-degenerate", "--compat", "khr"}), 0) << err_;
  must_run({"encode", path("kept.gltf"), path("unused.gltf"), "--skip", "unused"});
  EXPECT_TRUE(contains(err_, "is left as it is")) << err_;
  EXPECT_FALSE(contains(err_, "left out"));
  EXPECT_EQ(read_json("unused.gltf")["meshes"], read_json("kept.gltf")["meshes"]);
  fails(5, {"encode", path("kept.gltf"), path("x.gltf"), "--skip", "TEXCOORD_1"},
        "the primitive is left as it is");
  // A set that is read keeps those before it, because glTF counts from 0 without gaps.
  nlohmann::json json = asset();
  json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  EXPECT_EQ(kept(json), (Names{"POSITION", "TEXCOORD_0", "TEXCOORD_1"}));
  EXPECT_FALSE(contains(err_, "left out"));
  json = asset();
  primitive(json).erase("material");
  EXPECT_EQ(kept(json), Names{"POSITION"});
  // An attribute of the application stays: only its readers know.
  EXPECT_EQ(kept(json, "_CUSTOM"), (Names{"POSITION", "_CUSTOM"}));
  // Tangents and joints.
  const auto with = [&](const std::string& semantic, nlohmann::json of) {
    of["accessors"].push_back(
        {{"componentType", semantic == "JOINTS_0" ? 5121 : 5126}, {"count", kPoints}, {"type", "VEC4"}});
    primitive(of)["attributes"][semantic] = of["accessors"].size() - 1;
    return of;
  };
  json = with("TANGENT", asset());
  EXPECT_EQ(kept(json), (Names{"POSITION", "TEXCOORD_0"}));
  json["materials"][0]["normalTexture"] = {{"index", 0}};
  EXPECT_EQ(kept(json), (Names{"POSITION", "TANGENT", "TEXCOORD_0"}));
  json = with("WEIGHTS_0", with("JOINTS_0", asset()));
  EXPECT_EQ(kept(json), (Names{"POSITION", "TEXCOORD_0"}));
  json["nodes"] = {{{"mesh", 0}, {"skin", 0}}};
  json["skins"] = {{{"joints", {0}}}};
  EXPECT_EQ(kept(json), (Names{"JOINTS_0", "POSITION", "TEXCOORD_0", "WEIGHTS_0"}));
  // A target of nothing but an unused attribute.
  json = asset();
  primitive(json)["targets"] = {{{"TEXCOORD_1", 2}}};
  EXPECT_EQ(kept(json), (Names{"POSITION", "TEXCOORD_0", "TEXCOORD_1"}));
}

}  // namespace
}  // namespace psplit
