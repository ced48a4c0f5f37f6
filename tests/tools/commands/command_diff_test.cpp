// gltf-psplit diff: exit codes, messages, and the fields of its JSON.

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gltf_ext/json/json.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/mesh_file_seeds.h"
#include "tests/tools/run_command.h"

namespace psplit {
namespace {

class DiffCommand : public CommandTest {
 protected:
  int diff(const std::string& a, const std::string& b, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"diff", path(a), path(b)};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }

  void SetUp() override {
    ASSERT_EQ(run({"generate", path("plain.glb"), "--shape", "terrain", "--faces", "3000", "--normals", "-q"}),
              0);
    ASSERT_EQ(run({"encode", path("plain.glb"), path("split.glb"), "--patches", "5", "-q"}), 0);
  }

  // plain.glb with the first coordinate of one point changed. around_ is the number of triangles at that point.
  void move_point(const std::string& name, uint32_t point, float by) {
    Mesh mesh = must(read(must(read_document(path("plain.glb")))));
    around_ = 0;
    for (const auto& face : mesh.faces) around_ += std::ranges::count(face, point);
    for (Attribute& attribute : mesh.attributes) {
      if (attribute.semantic != "POSITION") continue;
      float x;
      std::memcpy(&x, attribute.values.data() + point * attribute.stride(), sizeof x);
      x += by;
      std::memcpy(attribute.values.data() + point * attribute.stride(), &x, sizeof x);
    }
    ASSERT_TRUE(write_document(document_from_mesh(mesh), path(name)).ok());
  }

  ptrdiff_t around_ = 0;
};

TEST_F(DiffCommand, WhatTheCommandWritesIsTheSameInOneLine) {
  must_run({"decode", path("split.glb"), path("decoded.glb"), "-q"});
  must_run({"encode", path("plain.glb"), path("khr.glb"), "--compat", "khr", "--patches", "5", "-q"});
  must_run({"decode", path("plain.glb"), path("stock.glb"), "--to", "draco", "-q"});
  EXPECT_EQ(diff("plain.glb", "split.glb"), 0) << out_;
  EXPECT_EQ(out_.find("same: 3,"), 0u) << out_;
  EXPECT_TRUE(contains(out_, "largest difference NORMAL "));
  EXPECT_TRUE(contains(out_, "POSITION "));
  EXPECT_EQ(std::ranges::count(out_, '\n'), 1);
  EXPECT_EQ(err_, "");
  EXPECT_EQ(diff("split.glb", "plain.glb"), 0) << out_;
  EXPECT_EQ(diff("split.glb", "decoded.glb", {"--tolerance", "0"}), 0) << out_;
  EXPECT_TRUE(contains(out_, "every value equal"));
  EXPECT_EQ(diff("split.glb", "stock.glb"), 0) << out_;
  EXPECT_EQ(diff("plain.glb", "khr.glb"), 0) << out_;
  EXPECT_TRUE(contains(out_, "in 1 primitive and 5"));
  EXPECT_TRUE(contains(err_, "compared as wholes"));
  EXPECT_EQ(diff("plain.glb", "khr.glb", {"-q"}), 0);
  EXPECT_EQ(err_, "");
  EXPECT_EQ(diff("split.glb", "khr.glb", {"--tolerance", "0"}), 0) << out_;
}

TEST_F(DiffCommand, DifferencesHaveAnExitCodeAndAPlace) {
  move_point("moved.glb", 100, 0.25f);
  EXPECT_EQ(diff("plain.glb", "moved.glb"), 7);
  EXPECT_EQ(out_.find("differs: " + path("plain.glb") + ": mesh 0, primitive 0, face "), 0u) << out_;
  for (const std::string& text : {std::string(", corner "), std::string(": POSITION is ("),
                                  "without counterpart: " + std::to_string(around_) + " of "})
    EXPECT_TRUE(contains(out_, text)) << text << " in " << out_;
  EXPECT_TRUE(contains(err_, "do not hold the same meshes"));
  EXPECT_EQ(diff("split.glb", "moved.glb"), 7);
  EXPECT_EQ(diff("plain.glb", "moved.glb", {"--tolerance", "NORMAL=0,POSITION=0.5"}), 0);
  EXPECT_EQ(diff("plain.glb", "split.glb", {"--tolerance", "0"}), 7);
  EXPECT_EQ(diff("plain.glb", "split.glb", {"--tolerance", "POSITION=1e-4"}), 0);
}

TEST_F(DiffCommand, NamesOfAttributesAreChecked) {
  move_point("moved.glb", 100, 0.25f);
  for (const std::string name : {"NORMALS", "FOO", "TEXCOORD", "TEXCOORD_", "COLOR_x", "NORMAL_0"}) {
    EXPECT_EQ(diff("plain.glb", "split.glb", {"--attributes", name}), 1) << name;
    EXPECT_EQ(diff("plain.glb", "split.glb", {"--tolerance", name + "=0.1"}), 1) << name;
    EXPECT_TRUE(contains(err_, name)) << err_;
  }
  EXPECT_EQ(diff("plain.glb", "split.glb", {"--attributes", "NORMAL,_AREA,TEXCOORD_0"}), 0);
  EXPECT_TRUE(contains(err_, "neither file has TEXCOORD_0")) << err_;
  EXPECT_TRUE(contains(err_, "neither file has _AREA"));
  EXPECT_FALSE(contains(err_, "neither file has NORMAL"));
  EXPECT_EQ(diff("plain.glb", "split.glb", {"--tolerance", "COLOR_0=0.1"}), 0);
  EXPECT_TRUE(contains(err_, "neither file has COLOR_0"));
}

TEST_F(DiffCommand, WhereGridsAreMissingToleranceIsNamed) {
  must_run({"decode", path("split.glb"), path("decoded.glb"), "-q"});
  EXPECT_EQ(diff("plain.glb", "decoded.glb"), 7);
  EXPECT_TRUE(contains(err_, "neither file declares a quantization grid")) << err_;
  EXPECT_EQ(diff("plain.glb", "decoded.glb", {"--tolerance", "0"}), 7);
  EXPECT_FALSE(contains(err_, "quantization grid"));
  EXPECT_EQ(diff("plain.glb", "decoded.glb", {"--tolerance", "0.01"}), 0);
}

TEST_F(DiffCommand, ScenesAreComparedWhereTheirNodesAre) {
  Document document = must(read_document(path("plain.glb")));
  document.json()["nodes"][0]["translation"] = {0, 0, 1};
  ASSERT_TRUE(write_document(document, path("raised.glb")).ok());
  EXPECT_EQ(diff("split.glb", "raised.glb"), 0) << out_;
  EXPECT_EQ(diff("split.glb", "raised.glb", {"--scene"}), 7) << out_;
  EXPECT_EQ(diff("plain.glb", "split.glb", {"--scene"}), 0) << out_;
}

// With little memory the answer is the same, word for word.
class SamenessWithLittleMemory : public DiffCommand {
 protected:
  int compare_twice(const std::string& a, const std::string& b, std::vector<std::string> more = {}) {
    const int code = diff(a, b, more);
    const std::string text = out_;
    more.insert(more.end(), {"--memory", "1kB"});
    EXPECT_EQ(diff(a, b, more), code) << a << " " << b << ": " << text << err_;
    EXPECT_EQ(out_, text) << a << " " << b;
    return code;
  }

  Mesh mesh() const { return must(read(must(read_document(path("plain.glb"))))); }
  void write_mesh(const Mesh& changed, const std::string& name) {
    ASSERT_TRUE(write_document(document_from_mesh(changed), path(name)).ok());
  }
};

TEST_F(SamenessWithLittleMemory, FilesOfAllKindsAreCompared) {
  must_run({"decode", path("split.glb"), path("decoded.glb"), "-q"});
  must_run({"encode", path("plain.glb"), path("other.glb"), "--patches", "3", "-q"});
  must_run({"encode", path("plain.glb"), path("coarse.glb"), "--quantize-normal", "6", "-q"});
  must_run({"encode", path("plain.glb"), path("khr.glb"), "--compat", "khr", "--patches", "5", "-q"});
  must_run({"generate", path("plain.ply"), "--shape", "terrain", "--faces", "3000", "--normals", "-q"});
  for (const std::string a : {"plain.glb", "plain.ply", "split.glb"})
    for (const std::string b : {"split.glb", "other.glb", "coarse.glb", "khr.glb"}) {
      EXPECT_EQ(compare_twice(a, b), 0) << out_;
      EXPECT_EQ(compare_twice(b, a), 0) << out_;
    }
  EXPECT_EQ(compare_twice("plain.glb", "plain.ply"), 0) << out_;
  EXPECT_EQ(compare_twice("split.glb", "decoded.glb"), 0) << out_;
  EXPECT_EQ(compare_twice("plain.glb", "decoded.glb"), 7) << out_;
  EXPECT_EQ(compare_twice("plain.glb", "split.glb", {"--tolerance", "0"}), 7);
  EXPECT_EQ(compare_twice("plain.glb", "split.glb", {"--tolerance", "1e-2"}), 0);
  EXPECT_EQ(diff("plain.glb", "split.glb", {"--memory", "1kB", "--scene"}), 1);

  move_point("moved.glb", 100, 0.25f);
  EXPECT_EQ(compare_twice("plain.glb", "moved.glb"), 7);
  EXPECT_EQ(compare_twice("moved.glb", "split.glb", {"--format", "json"}), 7);
}

TEST_F(SamenessWithLittleMemory, AllAttributesCount) {
  Mesh bare = mesh();
  std::erase_if(bare.attributes, [](const Attribute& attribute) { return attribute.semantic == "NORMAL"; });
  write_mesh(bare, "bare.glb");
  for (const std::string other : {"plain.glb", "split.glb"}) {
    EXPECT_EQ(compare_twice(other, "bare.glb"), 7);
    EXPECT_TRUE(contains(out_, "has NORMAL, which the other file lacks"));
    EXPECT_EQ(compare_twice("bare.glb", other), 7);
    EXPECT_EQ(compare_twice(other, "bare.glb", {"--attributes", "POSITION"}), 0) << out_;
  }

  const Mesh rich = rich_mesh(40, 30);
  write_mesh(rich, "rich.glb");
  must_run({"encode", path("rich.glb"), path("rich_split.glb"), "--patches", "4", "-q"});
  must_run({"decode", path("rich.glb"), path("rich_stock.glb"), "--to", "draco", "-q"});
  EXPECT_EQ(compare_twice("rich.glb", "rich_split.glb"), 0) << out_;
  EXPECT_EQ(compare_twice("rich.glb", "rich_stock.glb"), 0) << out_;
  EXPECT_EQ(compare_twice("rich_stock.glb", "rich_split.glb"), 0) << out_;
  for (size_t i = 0; i < rich.attributes.size(); ++i) {
    Mesh changed = rich;
    Attribute& attribute = changed.attributes[i];
    const float value = 0.5f;
    if (attribute.component_type == ComponentType::kFloat32)
      std::memcpy(attribute.values.data(), &value, sizeof value);
    else
      attribute.values[0] = std::byte{77};
    write_mesh(changed, "changed.glb");
    EXPECT_EQ(compare_twice("changed.glb", "rich_split.glb"), 7) << attribute.semantic;
    EXPECT_TRUE(contains(out_, attribute.semantic + " is ("));
  }

  Mesh other_type = rich;
  for (Attribute& attribute : other_type.attributes)
    if (attribute.semantic == "JOINTS_0") {
      const std::vector<uint8_t> joints = values_of<uint8_t>(attribute);
      attribute = make_attribute("JOINTS_0", ComponentType::kUint16, 4, false,
                                 std::vector<uint16_t>(joints.begin(), joints.end()));
    }
  write_mesh(other_type, "other_type.glb");
  EXPECT_EQ(compare_twice("rich.glb", "other_type.glb"), 0) << out_;
}

TEST_F(SamenessWithLittleMemory, MaterialsOrderAndKindsOfPrimitivesCount) {
  const Document document = must(read_document(path("plain.glb")));
  Document two = document;
  two.json()["materials"] = {Json::object(), Json::object()};
  Json& primitives = two.json()["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[0]["material"] = 0;
  primitives[1]["material"] = 1;
  ASSERT_TRUE(write_document(two, path("two.glb")).ok());
  std::swap(primitives[0], primitives[1]);
  ASSERT_TRUE(write_document(two, path("swapped.glb")).ok());
  EXPECT_EQ(compare_twice("two.glb", "swapped.glb"), 0) << out_;
  primitives[0]["material"] = 0;
  ASSERT_TRUE(write_document(two, path("one_material.glb")).ok());
  EXPECT_EQ(compare_twice("two.glb", "one_material.glb"), 7) << out_;

  // Primitives in another order, on other grids.
  primitives[1]["attributes"].erase("NORMAL");
  ASSERT_TRUE(write_document(two, path("two.glb")).ok());
  std::swap(primitives[0], primitives[1]);
  ASSERT_TRUE(write_document(two, path("swapped.glb")).ok());
  must_run({"encode", path("two.glb"), path("fine.glb"), "-q"});
  must_run({"encode", path("swapped.glb"), path("coarse.glb"), "--quantize-position", "12", "-q"});
  EXPECT_EQ(compare_twice("fine.glb", "coarse.glb"), 0) << out_;

  // Lines and morph targets.
  primitives[0]["mode"] = 1;
  for (Json& primitive : primitives)
    primitive["targets"] = Json::array({{{"POSITION", primitive["attributes"]["POSITION"]}}});
  ASSERT_TRUE(write_document(two, path("mixed.glb")).ok());
  EXPECT_EQ(compare_twice("mixed.glb", "mixed.glb"), 0) << out_;
  EXPECT_EQ(compare_twice("mixed.glb", "swapped.glb"), 7) << out_;
}

TEST_F(DiffCommand, WithLittleMemoryTheResultReplacesNoFileOfAnInput) {
  must_run({"decode", path("plain.glb"), path("plain.gltf"), "-q"});
  std::string binary;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    if (entry.path().extension() == ".bin") binary = entry.path().filename().string();
  ASSERT_FALSE(binary.empty());
  const std::string before = read_bytes(path(binary));
  for (const auto& [a, b] : {std::pair("plain.gltf", "plain.glb"), std::pair("plain.glb", "plain.gltf")}) {
    EXPECT_EQ(diff(a, b, {"--memory", "1kB", "--output", path(binary)}), 1) << out_;
    EXPECT_TRUE(contains(err_, "--output would replace"));
  }
  EXPECT_EQ(read_bytes(path(binary)), before);
}

// Facets whose normals have no direction or another length are repaired as for encoding.
TEST_F(DiffCommand, WithLittleMemoryNormalsOfFacetsAreRepaired) {
  std::vector<StlFacet> facets;
  for (uint32_t i = 0; i < 40; ++i) {
    const auto x = static_cast<float>(i);
    facets.push_back({0, 0, i == 3 ? 0.0f : i % 2 == 0 ? 1.0f : 2.0f, x, 0, 0, x + 1, 0, 0, x, 1, 0});
  }
  write("a.stl", binary_stl(facets));
  must_run({"encode", path("a.stl"), path("a.glb"), "--always-patches", "-q"});
  EXPECT_EQ(diff("a.stl", "a.glb"), 0) << out_;
  EXPECT_EQ(diff("a.stl", "a.glb", {"--memory", "1kB"}), 0) << out_ << err_;
}

TEST_F(DiffCommand, JsonSaysTheSame) {
  ASSERT_EQ(diff("plain.glb", "split.glb", {"--format", "json"}), 0);
  const auto json = nlohmann::json::parse(out_);
  EXPECT_EQ(json.at("same"), true);
  EXPECT_EQ(json.at("first_difference"), nullptr);
  EXPECT_EQ(json.at("a").at("triangles"), json.at("b").at("triangles"));
  EXPECT_EQ(json.at("a").at("without_counterpart"), 0);
  ASSERT_EQ(json.at("attributes").size(), 2u);
  for (const auto& attribute : json.at("attributes")) {
    EXPECT_GT(attribute.at("largest_difference").get<double>(), 0);
    EXPECT_LE(attribute.at("largest_difference").get<double>(), attribute.at("tolerance").get<double>());
  }

  move_point("moved.glb", 100, 0.25f);
  ASSERT_EQ(diff("plain.glb", "moved.glb", {"--format", "json", "--attributes", "NORMAL"}), 7);
  const auto differs = nlohmann::json::parse(out_);
  EXPECT_EQ(differs.at("same"), false);
  const auto& first = differs.at("first_difference");
  EXPECT_EQ(first.at("in"), "a");
  EXPECT_EQ(first.at("mesh"), 0);
  EXPECT_EQ(first.at("attribute"), "POSITION");
  EXPECT_NEAR(first.at("other_value").at(0).get<double>() - first.at("value").at(0).get<double>(), 0.25, 1e-6);
  EXPECT_EQ(differs.at("a").at("without_counterpart"), around_);
}

TEST_F(DiffCommand, FilesThatDoNotReadAndOptionsThatDoNotFitAreErrors) {
  EXPECT_EQ(diff("plain.glb", "missing.glb"), 2);
  EXPECT_TRUE(contains(err_, "missing.glb"));
  std::ofstream(path("broken.glb")) << "glTF";
  EXPECT_EQ(diff("plain.glb", "broken.glb"), 3);
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--tolerance", "-1"},
                                             {"--tolerance", "2"},
                                             {"--tolerance", "=1"},
                                             {"--tolerance", "x"},
                                             {"--tolerance", "nan"},
                                             {"--patches", "3"},
                                             {"--quantize-position", "12"}})
    EXPECT_EQ(diff("plain.glb", "split.glb", more), 1) << more[0] << " " << more[1];
  EXPECT_EQ(run({"diff", path("plain.glb"), "--tolerance", "0"}), 1);
  EXPECT_EQ(run({"diff", "-", "-"}), 1);
}

}  // namespace
}  // namespace psplit
