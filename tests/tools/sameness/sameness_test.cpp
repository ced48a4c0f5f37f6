// gltf-psplit compare A B: exit codes, messages, and the fields of its JSON.
#include <gtest/gtest.h>

#include <algorithm>
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
      EXPECT_EQ(out_.find("not compared: NORMAL") == std::string::npos, a == "split.glb") << out_;
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
