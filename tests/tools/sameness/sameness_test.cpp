// gltf-psplit compare A B: exit codes, messages, and the fields of its JSON.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "encoder/draco/draco_backend.h"
#include "gltf_ext/convert/document_from_mesh.h"
#include "gltf_ext/document/write_document.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "tests/tools/run_command.h"

namespace psplit {
namespace {

class Sameness : public CommandTest {
 protected:
  int compare(const std::string& a, const std::string& b, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"compare", path(a), path(b)};
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
    Expected<Document> document = read_document(path("plain.glb"));
    ASSERT_TRUE(document);
    Expected<Mesh> mesh = read_primitive(*document, {}, draco_backend(), ThreadPool(1));
    ASSERT_TRUE(mesh);
    around_ = 0;
    for (const auto& face : mesh->faces) around_ += std::ranges::count(face, point);
    for (Attribute& attribute : mesh->attributes) {
      if (attribute.semantic != "POSITION") continue;
      float x;
      std::memcpy(&x, attribute.values.data() + point * attribute.stride(), sizeof x);
      x += by;
      std::memcpy(attribute.values.data() + point * attribute.stride(), &x, sizeof x);
    }
    ASSERT_TRUE(write_document(document_from_mesh(*mesh), path(name)).ok());
  }

  ptrdiff_t around_ = 0;
};

TEST_F(Sameness, WhatTheCommandWritesIsTheSameInOneLine) {
  ASSERT_EQ(run({"decode", path("split.glb"), path("decoded.glb"), "-q"}), 0);
  ASSERT_EQ(run({"encode", path("plain.glb"), path("khr.glb"), "--compat", "khr", "--patches", "5", "-q"}), 0);
  ASSERT_EQ(run({"decode", path("plain.glb"), path("stock.glb"), "--to", "draco", "-q"}), 0);
  EXPECT_EQ(compare("plain.glb", "split.glb"), 0) << out_;
  EXPECT_EQ(out_.find("same: 3,"), 0u) << out_;
  EXPECT_NE(out_.find("largest difference NORMAL "), std::string::npos) << out_;
  EXPECT_NE(out_.find("POSITION "), std::string::npos) << out_;
  EXPECT_EQ(std::ranges::count(out_, '\n'), 1);
  EXPECT_EQ(err_, "");
  EXPECT_EQ(compare("split.glb", "plain.glb"), 0) << out_;
  EXPECT_EQ(compare("split.glb", "decoded.glb", {"--tolerance", "0"}), 0) << out_;
  EXPECT_NE(out_.find("every value equal"), std::string::npos) << out_;
  EXPECT_EQ(compare("split.glb", "stock.glb"), 0) << out_;
  EXPECT_EQ(compare("plain.glb", "khr.glb"), 0) << out_;
  EXPECT_NE(out_.find("in 1 primitive and 5"), std::string::npos) << out_;
  EXPECT_NE(err_.find("compared as wholes"), std::string::npos) << err_;
  EXPECT_EQ(compare("plain.glb", "khr.glb", {"-q"}), 0);
  EXPECT_EQ(err_, "");
  EXPECT_EQ(compare("split.glb", "khr.glb", {"--tolerance", "0"}), 0) << out_;
}

TEST_F(Sameness, DifferencesHaveAnExitCodeAndAPlace) {
  move_point("moved.glb", 100, 0.25f);
  EXPECT_EQ(compare("plain.glb", "moved.glb"), 7);
  EXPECT_EQ(out_.find("differs: " + path("plain.glb") + ": mesh 0, primitive 0, face "), 0u) << out_;
  for (const std::string& text : {std::string(", corner "), std::string(": POSITION is ("),
                                  "without counterpart: " + std::to_string(around_) + " of "})
    EXPECT_NE(out_.find(text), std::string::npos) << text << " in " << out_;
  EXPECT_NE(err_.find("do not hold the same meshes"), std::string::npos) << err_;
  EXPECT_EQ(compare("split.glb", "moved.glb"), 7);
  EXPECT_EQ(compare("plain.glb", "moved.glb", {"--tolerance", "NORMAL=0,POSITION=0.5"}), 0);
  EXPECT_EQ(compare("plain.glb", "split.glb", {"--tolerance", "0"}), 7);
  EXPECT_EQ(compare("plain.glb", "split.glb", {"--tolerance", "POSITION=1e-4"}), 0);
}

TEST_F(Sameness, ScenesAreComparedWhereTheirNodesAre) {
  Expected<Document> document = read_document(path("plain.glb"));
  ASSERT_TRUE(document);
  document->json["nodes"][0]["translation"] = {0, 0, 1};
  ASSERT_TRUE(write_document(*document, path("raised.glb")).ok());
  EXPECT_EQ(compare("split.glb", "raised.glb"), 0) << out_;
  EXPECT_EQ(compare("split.glb", "raised.glb", {"--scene"}), 7) << out_;
  EXPECT_EQ(compare("plain.glb", "split.glb", {"--scene"}), 0) << out_;
}

TEST_F(Sameness, WithLittleMemorySumsOfHashesAreCompared) {
  const std::vector<std::string> little{"--memory", "100kB"};
  ASSERT_EQ(run({"decode", path("split.glb"), path("decoded.glb"), "-q"}), 0);
  ASSERT_EQ(run({"encode", path("plain.glb"), path("other.glb"), "--patches", "3", "-q"}), 0);
  ASSERT_EQ(run({"generate", path("plain.ply"), "--shape", "terrain", "--faces", "3000", "--normals", "-q"}),
            0);
  for (const std::string a : {"plain.glb", "plain.ply", "split.glb"})
    for (const std::string b : {"split.glb", "other.glb"}) {
      EXPECT_EQ(compare(a, b, little), 0) << a << " " << b << ": " << out_ << err_;
      EXPECT_EQ(out_.find("same by sums of hashes: "), 0u) << out_;
      EXPECT_EQ(out_.find("not compared"), std::string::npos) << out_;
      EXPECT_EQ(out_.find("rounded to the grid of the other asset: NORMAL, POSITION") == std::string::npos,
                a == "split.glb")
          << out_;
      EXPECT_EQ(compare(b, a, little), 0) << a << " " << b << ": " << out_ << err_;
    }
  EXPECT_EQ(compare("plain.glb", "plain.ply", little), 0) << out_;
  EXPECT_EQ(compare("split.glb", "decoded.glb", little), 0) << out_;
  EXPECT_EQ(compare("plain.glb", "decoded.glb", little), 7) << out_;

  move_point("moved.glb", 100, 0.25f);
  EXPECT_EQ(compare("plain.glb", "moved.glb", little), 7);
  EXPECT_EQ(out_.find("differs: mesh 0: "), 0u) << out_;
  EXPECT_NE(out_.find(" of 4,096 cells, between ("), std::string::npos) << out_;
  EXPECT_EQ(compare("moved.glb", "split.glb", {"--memory", "100kB", "--format", "json"}), 7);
  const auto json = nlohmann::json::parse(out_);
  EXPECT_EQ(json.at("same"), false);
  EXPECT_GT(json.at("meshes").at(0).at("difference").at("cells"), 0);
  EXPECT_EQ(compare("plain.glb", "split.glb", {"--memory", "100kB", "--tolerance", "0"}), 1);
}

// What is compared in memory is compared with little memory, too.
TEST_F(Sameness, WithLittleMemoryAllAttributesCount) {
  const auto code = [&](const std::string& a, const std::string& b) {
    const int forth = compare(a, b, {"--memory", "1kB"});
    EXPECT_EQ(compare(b, a, {"--memory", "1kB"}), forth) << a << " " << b;
    EXPECT_EQ(out_.starts_with("same"), forth == 0) << out_;
    return forth;
  };
  const auto mesh = [&] {
    const Expected<Document> document = read_document(path("plain.glb"));
    return *read_primitive(*document, {}, draco_backend(), ThreadPool(1));
  };
  const auto write = [&](const Mesh& changed, const std::string& name) {
    ASSERT_TRUE(write_document(document_from_mesh(changed), path(name)).ok());
  };
  Mesh bare = mesh();
  std::erase_if(bare.attributes, [](const Attribute& attribute) { return attribute.semantic == "NORMAL"; });
  write(bare, "bare.glb");
  for (const std::string other : {"plain.glb", "split.glb"}) {
    EXPECT_EQ(code(other, "bare.glb"), 7);
    EXPECT_TRUE(contains(out_, "file lacks NORMAL")) << out_;
    EXPECT_EQ(compare(other, "bare.glb", {"--memory", "1kB", "--attributes", "POSITION"}), 0) << out_;
  }
  Mesh tilted = mesh();
  for (Attribute& attribute : tilted.attributes)
    if (attribute.semantic == "NORMAL") {
      const std::array<float, 3> normal{0.6f, 0.8f, 0};
      std::memcpy(attribute.values.data(), normal.data(), sizeof normal);
    }
  write(tilted, "tilted.glb");
  for (const std::string other : {"plain.glb", "split.glb"}) {
    EXPECT_EQ(code(other, "tilted.glb"), 7);
    EXPECT_TRUE(contains(out_, "differences of NORMAL in ")) << out_;
  }
  ASSERT_EQ(run({"encode", path("plain.glb"), path("coarse.glb"), "--quantize-normal", "6", "-q"}), 0);
  EXPECT_EQ(code("plain.glb", "coarse.glb"), 0) << out_ << err_;
  EXPECT_EQ(code("split.glb", "coarse.glb"), 5);
  EXPECT_TRUE(contains(out_, "not compared, because types or grids differ: NORMAL")) << out_;
  EXPECT_TRUE(contains(err_, "not known to be the same")) << err_;
  EXPECT_EQ(compare("split.glb", "coarse.glb", {"--memory", "1kB", "--attributes", "POSITION"}), 0) << out_;

  // Colours, texture coordinates, skins and tangents, some of them beyond glTF's limits by rounding noise.
  Mesh rich = mesh();
  const auto add = [&](const std::string& semantic, uint8_t components, const auto& value) {
    Attribute attribute{semantic, ComponentType::kFloat32, components, false, {}};
    attribute.values.resize(rich.point_count * attribute.stride());
    for (uint32_t i = 0; i < rich.point_count * components; ++i) {
      const float number = value(i);
      std::memcpy(attribute.values.data() + i * sizeof number, &number, sizeof number);
    }
    rich.attributes.push_back(std::move(attribute));
  };
  add("COLOR_0", 4,
      [](uint32_t i) { return static_cast<float>(i * 7919 % 1000) / 1000 + (i % 9 == 0 ? 1e-6f : 0); });
  add("TEXCOORD_0", 2, [](uint32_t i) { return static_cast<float>(i * 104729 % 1000) / 300 - 1; });
  add("TANGENT", 4, [](uint32_t i) { return i % 4 == 3 ? 1 : static_cast<float>(i * 31 % 200) / 100 - 1; });
  add("WEIGHTS_0", 4, [](uint32_t i) {
    constexpr std::array<float, 8> kWeights{0.31f, 0.29f, 0.11f, 0.29f, 0.71f, 0.23f, 0.05f, 0.01f};
    return kWeights[i % 8];
  });
  Attribute joints{"JOINTS_0", ComponentType::kUint8, 4, false, {}};
  joints.values.assign(4 * size_t{rich.point_count}, std::byte{1});
  rich.attributes.push_back(joints);
  write(rich, "rich.glb");
  ASSERT_EQ(run({"encode", path("rich.glb"), path("rich_split.glb"), "--patches", "4", "-q"}), 0) << err_;
  ASSERT_EQ(run({"decode", path("rich.glb"), path("rich_stock.glb"), "--to", "draco", "-q"}), 0) << err_;
  ASSERT_EQ(compare("rich.glb", "rich_split.glb"), 0) << out_;
  EXPECT_EQ(code("rich.glb", "rich_split.glb"), 0) << out_ << err_;
  EXPECT_EQ(code("rich.glb", "rich_stock.glb"), 0) << out_ << err_;
  EXPECT_EQ(code("rich_stock.glb", "rich_split.glb"), 0) << out_ << err_;
  for (const char* semantic : {"COLOR_0", "TEXCOORD_0", "TANGENT", "WEIGHTS_0", "JOINTS_0"}) {
    Mesh changed = rich;
    for (Attribute& attribute : changed.attributes)
      if (attribute.semantic == semantic) {
        const float value = 0.5f;
        if (attribute.component_type == ComponentType::kFloat32)
          std::memcpy(attribute.values.data(), &value, sizeof value);
        else
          attribute.values[0] = std::byte{2};
      }
    write(changed, "changed.glb");
    EXPECT_EQ(code("changed.glb", "rich_split.glb"), 7) << semantic;
    EXPECT_TRUE(contains(out_, "differences of " + std::string(semantic))) << out_;
  }

  // Another type: in memory it may be the same within a tolerance. Sums do not tell.
  Mesh other_type = rich;
  for (Attribute& attribute : other_type.attributes)
    if (attribute.semantic == "JOINTS_0") {
      attribute.component_type = ComponentType::kUint16;
      attribute.values.assign(8 * size_t{rich.point_count}, std::byte{0});
      for (size_t i = 0; i < attribute.values.size(); i += 2) attribute.values[i] = std::byte{1};
    }
  write(other_type, "other_type.glb");
  EXPECT_EQ(code("rich.glb", "other_type.glb"), 5);
  EXPECT_TRUE(contains(out_, "types or grids differ: JOINTS_0")) << out_;
}

TEST_F(Sameness, WithLittleMemoryMaterialsAndPrimitivesCountAsInMemory) {
  Expected<Document> document = read_document(path("plain.glb"));
  ASSERT_TRUE(document);
  Document two = *document;
  two.json["materials"] = {Json::object(), Json::object()};
  Json& primitives = two.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[0]["material"] = 0;
  primitives[1]["material"] = 1;
  ASSERT_TRUE(write_document(two, path("two.glb")).ok());
  std::swap(primitives[0], primitives[1]);
  ASSERT_TRUE(write_document(two, path("swapped.glb")).ok());
  primitives[0]["material"] = 0;
  ASSERT_TRUE(write_document(two, path("one_material.glb")).ok());
  for (const auto& [other, code] : {std::pair("swapped.glb", 0), std::pair("one_material.glb", 7)}) {
    EXPECT_EQ(compare("two.glb", other), code) << out_;
    EXPECT_EQ(compare("two.glb", other, {"--memory", "1kB"}), code) << out_;
  }
}

// Primitives in another order on other grids are the same in memory, and undecided by sums.
TEST_F(Sameness, WithLittleMemoryPrimitivesInAnotherOrderAreNotDifferent) {
  Expected<Document> document = read_document(path("plain.glb"));
  ASSERT_TRUE(document);
  Json& primitives = document->json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[1]["attributes"].erase("NORMAL");
  ASSERT_TRUE(write_document(*document, path("two.glb")).ok());
  std::swap(primitives[0], primitives[1]);
  ASSERT_TRUE(write_document(*document, path("swapped.glb")).ok());
  ASSERT_EQ(run({"encode", path("two.glb"), path("fine.glb"), "-q"}), 0) << err_;
  ASSERT_EQ(run({"encode", path("swapped.glb"), path("coarse.glb"), "--quantize-position", "12", "-q"}), 0);
  EXPECT_EQ(compare("two.glb", "swapped.glb", {"--memory", "1kB"}), 0) << out_;
  EXPECT_EQ(compare("fine.glb", "coarse.glb"), 0) << out_;
  EXPECT_EQ(compare("fine.glb", "coarse.glb", {"--memory", "1kB"}), 5) << out_;
}

TEST_F(Sameness, WithLittleMemoryTheResultReplacesNoFileOfAnInput) {
  ASSERT_EQ(run({"decode", path("plain.glb"), path("plain.gltf"), "-q"}), 0) << err_;
  std::string binary;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    if (entry.path().extension() == ".bin") binary = entry.path().filename().string();
  ASSERT_FALSE(binary.empty());
  const std::string before = read_bytes(path(binary));
  for (const auto& [a, b] : {std::pair("plain.gltf", "plain.glb"), std::pair("plain.glb", "plain.gltf")}) {
    EXPECT_EQ(compare(a, b, {"--memory", "1kB", "--output", path(binary)}), 1) << out_;
    EXPECT_TRUE(contains(err_, "--output would replace")) << err_;
  }
  EXPECT_EQ(read_bytes(path(binary)), before);
}

// Facets whose normals have no direction or another length are repaired as for encoding.
TEST_F(Sameness, WithLittleMemoryNormalsOfFacetsAreRepaired) {
  std::string stl(84, ' ');
  const uint32_t facets = 40;
  std::memcpy(stl.data() + 80, &facets, sizeof facets);
  for (uint32_t i = 0; i < facets; ++i) {
    const auto x = static_cast<float>(i);
    const float values[12] = {0, 0, i == 3 ? 0.0f : i % 2 == 0 ? 1.0f : 2.0f, x, 0, 0, x + 1, 0, 0, x, 1, 0};
    std::string facet(50, '\0');
    std::memcpy(facet.data(), values, sizeof values);
    stl += facet;
  }
  write("a.stl", stl);
  ASSERT_EQ(run({"encode", path("a.stl"), path("a.glb"), "--always-patches", "-q"}), 0) << err_;
  EXPECT_EQ(compare("a.stl", "a.glb"), 0) << out_;
  EXPECT_EQ(compare("a.stl", "a.glb", {"--memory", "1kB"}), 0) << out_ << err_;
  EXPECT_TRUE(contains(out_, "same by sums")) << out_;
}

TEST_F(Sameness, JsonSaysTheSame) {
  ASSERT_EQ(compare("plain.glb", "split.glb", {"--format", "json"}), 0);
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
  ASSERT_EQ(compare("plain.glb", "moved.glb", {"--format", "json", "--attributes", "NORMAL"}), 7);
  const auto differs = nlohmann::json::parse(out_);
  EXPECT_EQ(differs.at("same"), false);
  const auto& first = differs.at("first_difference");
  EXPECT_EQ(first.at("in"), "a");
  EXPECT_EQ(first.at("mesh"), 0);
  EXPECT_EQ(first.at("attribute"), "POSITION");
  EXPECT_NEAR(first.at("other_value").at(0).get<double>() - first.at("value").at(0).get<double>(), 0.25, 1e-6);
  EXPECT_EQ(differs.at("a").at("without_counterpart"), around_);
}

TEST_F(Sameness, FilesThatDoNotReadAndOptionsThatDoNotFitAreErrors) {
  EXPECT_EQ(compare("plain.glb", "missing.glb"), 2);
  EXPECT_NE(err_.find("missing.glb"), std::string::npos);
  std::ofstream(path("broken.glb")) << "glTF";
  EXPECT_EQ(compare("plain.glb", "broken.glb"), 3);
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--tolerance", "-1"},
                                             {"--tolerance", "2"},
                                             {"--tolerance", "=1"},
                                             {"--tolerance", "x"},
                                             {"--tolerance", "nan"},
                                             {"--patches", "3"},
                                             {"--quantize-position", "12"}})
    EXPECT_EQ(compare("plain.glb", "split.glb", more), 1) << more[0] << " " << more[1];
  EXPECT_EQ(run({"compare", path("plain.glb"), "--tolerance", "0"}), 1);
  EXPECT_EQ(run({"compare", "-", "-"}), 1);
}

}  // namespace
}  // namespace psplit
