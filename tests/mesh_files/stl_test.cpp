#include "mesh_files/stl.h"

#include <cctype>

#include "tests/mesh_files/mesh_text.h"

namespace psplit {
namespace {

constexpr float kTetrahedron[4][3][3] = {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}},
                                         {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                                         {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                         {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

std::string binary(const std::string& header, uint32_t claimed = 4, uint32_t written = 4, char attribute = 0) {
  std::string file = header;
  file.resize(80, ' ');
  file.append(reinterpret_cast<const char*>(&claimed), 4);
  for (uint32_t i = 0; i < written; ++i) {
    const float normal[3] = {0, 0, 1};
    file.append(reinterpret_cast<const char*>(normal), 12);
    file.append(reinterpret_cast<const char*>(kTetrahedron[i % 4]), 36);
    file.append(2, attribute);
  }
  return file;
}

std::string text(const std::string& name, const std::string& normal = "0 0 1") {
  std::string file = "solid" + (name.empty() ? "" : " " + name) + "\n";
  for (const auto& facet : kTetrahedron) {
    file += "  facet normal " + normal + "\n    outer loop\n";
    for (const auto& corner : facet) {
      file += "      vertex";
      for (const float value : corner) file += " " + std::to_string(value);
      file += "\n";
    }
    file += "    endloop\n  endfacet\n";
  }
  return file + "endsolid " + name + "\n";
}

TEST(Stl, TextAndBinaryAreToldApartByContent) {
  const std::string lower_case = text("a part");
  std::string upper_case = lower_case;
  for (char& c : upper_case) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string carriage_returns;
  for (const char c : lower_case) carriage_returns += c == '\n' ? "\r\n" : std::string(1, c);
  for (const std::string& file :
       {lower_case, upper_case, carriage_returns, "\n\n" + lower_case,
        lower_case.substr(0, lower_case.size() - 8), binary("made by a test"),
        binary("solid made by a CAD system"), binary("solid"), binary("SOLID facet normal")}) {
    const Mesh mesh = mesh_of(read_text(file));
    EXPECT_EQ(mesh.faces.size(), 4u) << file.substr(0, 30);
    // Corners with equal position and normal are one point.
    EXPECT_EQ(mesh.point_count, 4u) << file.substr(0, 30);
    EXPECT_NEAR(area_of(mesh), 1.5 + std::sqrt(0.75), 1e-6);
  }
}

TEST(Stl, SolidsAreObjects) {
  const Asset asset = must(read_text(text("one") + text("two") + "solid none\nendsolid\n" + text("")));
  const Json& meshes = asset.document.json()["meshes"];
  ASSERT_EQ(meshes.size(), 3u);
  EXPECT_EQ(meshes[0]["name"], "one");
  EXPECT_EQ(meshes[1]["name"], "two");
  EXPECT_FALSE(meshes[2].contains("name"));
}

TEST(Stl, NormalsThatSayNothingGo) {
  const Expected<Asset> zero = read_text(text("a", "0 0 0"));
  EXPECT_EQ(mesh_of(zero).find("NORMAL"), nullptr);
  EXPECT_EQ(warnings_of(zero), "no normal has a direction: all are left out\n");
  const Expected<Asset> longer = read_text(text("a", "0 3 4"));
  EXPECT_EQ(floats_of(mesh_of(longer), "NORMAL")[2], 0.8f);
  EXPECT_EQ(warnings_of(longer), "4 normals were not of unit length: normalized\n");
}

TEST(Stl, WhatIsLeftOutIsSaid) {
  EXPECT_EQ(warnings_of(read_text(binary("colours", 4, 4, 1))),
            "4 facets have two attribute bytes each, which are left out\n");
  EXPECT_EQ(warnings_of(read_text(binary("more") + "ab", "a.stl")),
            "2 bytes after the last facet are not read\n");
}

TEST(Stl, ErrorsSayWhere) {
  EXPECT_EQ(message_of(binary("liar", 40000000, 2), "a.stl"),
            "STL: the file claims 40000000 facets but ends after 2");
  EXPECT_EQ(message_of(binary("none", 0, 0)), "STL: no facets");
  EXPECT_EQ(message_of("solid a\nendsolid a\n"), "STL: no facets");
  EXPECT_EQ(message_of("solid a\nfacet normal 0 0 x\n"), "line 2: \"x\" is not a number");
  EXPECT_EQ(message_of(
                "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\nvertex 0 0 0\nvertex 1 0 0\nendloop\n"
                "endfacet\nendsolid\n"),
            "line 2: a position that is not finite");
  EXPECT_EQ(message_of("solid a\nvertex 0 0 1\n"),
            "line 2: \"vertex\" where \"facet\" or \"endsolid\" is expected");
  std::string nan = binary("nan");
  const float value = std::nanf("");
  std::memcpy(nan.data() + 84 + 50 + 12, &value, 4);
  EXPECT_EQ(message_of(nan), "byte 134: a position of facet 1 is not finite");
}

TEST(Stl, EveryTruncationIsRefused) {
  const std::string whole_text = text("part"), whole_binary = binary("solid part");
  const size_t end = whole_text.size() - std::string("endsolid part\n").size() + 8;
  for (size_t size = 0; size < end; ++size)
    EXPECT_FALSE(read_text(whole_text.substr(0, size), "a.stl").ok()) << size;
  for (size_t size = end; size < whole_text.size(); ++size)
    EXPECT_TRUE(read_text(whole_text.substr(0, size), "a.stl").ok()) << size;
  for (size_t size = 0; size < whole_binary.size(); ++size)
    EXPECT_FALSE(read_text(whole_binary.substr(0, size), "a.stl").ok()) << size;
}

}  // namespace
}  // namespace psplit
