#include "mesh_files/obj.h"

#include <fstream>

#include "mesh_files/mtl.h"
#include "psplit/decode.h"
#include "tests/mesh_files/mesh_text.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, CornersOfAllFormsNameTheirPoints) {
  const std::string attributes = kSquare + "vt 0 0\nvt 1 0.25 7\nvn 0 0 1\nvn 1 0 0\n";
  Expected<Asset> asset = read_text(attributes + "f 1/1/1 2/2/1 3/1/2\nf -4/-2/-2 -2/-2/-1 -1/2/-2");
  Mesh mesh = mesh_of(asset);
  EXPECT_EQ(warnings_of(asset), "");
  // Corners with the same three indices are one point; points are in the order of the faces.
  const Array<std::array<uint32_t, 3>> expected = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(mesh.faces, expected);
  EXPECT_EQ(floats_of(mesh, "POSITION"), (std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}));
  EXPECT_EQ(floats_of(mesh, "NORMAL"), (std::vector<float>{0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1}));
  // OBJ counts v from the bottom, glTF from the top.
  EXPECT_EQ(floats_of(mesh, "TEXCOORD_0"), (std::vector<float>{0, 1, 1, 0.75f, 0, 1, 1, 0.75f}));

  mesh = mesh_of(read_text(attributes + "f 1//1 2//1 3//2"));
  EXPECT_EQ(mesh.find("TEXCOORD_0"), nullptr);
  EXPECT_NE(mesh.find("NORMAL"), nullptr);
  mesh = mesh_of(read_text(attributes + "f 1/1 2/2 3/1/"));
  EXPECT_NE(mesh.find("TEXCOORD_0"), nullptr);
  EXPECT_EQ(mesh.find("NORMAL"), nullptr);
}

TEST(Obj, LinesEndInAnyWayAndGoOnBehindBackslashes) {
  const std::string lines = "# a comment\n\n" + kSquare + "  f 1 \\\n 2 3 # and another\nf 1 3\\\n 4\n";
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string file;
    for (const char c : lines) file += c == '\n' ? end : std::string(1, c);
    EXPECT_EQ(mesh_of(read_text(file)).faces.size(), 2u) << testing::PrintToString(end);
    EXPECT_EQ(mesh_of(read_text(file + "g a b\ns off\nf 2 3 4")).faces.size(), 3u);
  }
}

TEST(Obj, PolygonsOfAnySizeAreCovered) {
  for (const int corners : {4, 9, 67, 936, 1000}) {
    std::string file, face = "f";
    double area = 0;
    for (int i = 0; i < corners; ++i) {
      const double angle = 6.283185307 * i / corners, radius = i % 2 == 0 ? 2 : 0.5;
      file += "v 1 " + std::to_string(radius * std::cos(angle)) + " " +
              std::to_string(radius * std::sin(angle)) + "\n";
      face += " " + std::to_string(i - corners);
      area += 2 * 0.5 * std::sin(6.283185307 / corners) / 2;
    }
    const Expected<Asset> asset = read_text(file + face);
    const Mesh mesh = mesh_of(asset);
    EXPECT_EQ(mesh.faces.size(), static_cast<size_t>(corners - 2));
    if (corners % 2 == 0) {
      EXPECT_NEAR(area_of(mesh), area, 1e-4) << corners;
    }
    EXPECT_EQ(warnings_of(asset), "");
  }
}

TEST(Obj, ObjectsAreMeshesAndMaterialsPrimitives) {
  const TestFolder folder;
  std::ofstream(folder / "the colours.mtl")
      << "newmtl red\nKd 1 0 0\nd 0.5\nNs 0\nmap_Kd -s 2 2 2 images\\a b.png\n\n"
         "newmtl green\nKd 0 1 0\nPm 1\nPr 0.25\nKe 0 0 1\nmap_Ke images/a b.png\nmap_Bump bumps.png\n"
         "map_Kd /etc/passwd.png\nnewmtl unused\nmap_Kd other.png\nKd x\n";
  std::ofstream(folder / "asset.obj")
      << "mtllib the colours.mtl\n" + kSquare +
             "o front\nusemtl red\nf 1 2 3\nusemtl green\nf 1 3 4\nusemtl red\nf 2 3 4\n"
             "o back\nf 3 2 1\nvt 0 0\nvn 0 0 1\nf 3/1 2/1 1/1\nusemtl nowhere\nf 3 2 1\n";
  const Asset asset = must(read_asset(folder / "asset.obj", describe_stream));
  const Json& json = asset.document.json();
  ASSERT_EQ(json["meshes"].size(), 2u);
  EXPECT_EQ(json["meshes"][0]["name"], "front");
  EXPECT_EQ(json["nodes"][1]["name"], "back");
  EXPECT_EQ(json["scenes"][0]["nodes"], Json::array({0, 1}));
  ASSERT_EQ(json["meshes"][0]["primitives"].size(), 2u);
  EXPECT_EQ(json["meshes"][0]["primitives"][0]["material"], 0);
  EXPECT_EQ(json["meshes"][0]["primitives"][1]["material"], 1);
  EXPECT_EQ(mesh_of(asset, {0, 0}).faces.size(), 2u);
  // Faces with and without texture coordinates do not share a primitive.
  ASSERT_EQ(json["meshes"][1]["primitives"].size(), 3u);
  EXPECT_EQ(mesh_of(asset, {1, 0}).find("TEXCOORD_0"), nullptr);
  EXPECT_NE(mesh_of(asset, {1, 1}).find("TEXCOORD_0"), nullptr);
  ASSERT_EQ(json["materials"].size(), 3u);
  const Json& red = json["materials"][0];
  EXPECT_EQ(red["name"], "red");
  EXPECT_EQ(red["pbrMetallicRoughness"]["baseColorFactor"], Json::array({1.0f, 0.0f, 0.0f, 0.5f}));
  EXPECT_EQ(red["alphaMode"], "BLEND");
  EXPECT_EQ(red["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  EXPECT_EQ(red["pbrMetallicRoughness"]["roughnessFactor"], 1.0f);
  const Json& green = json["materials"][1];
  EXPECT_EQ(green["pbrMetallicRoughness"]["metallicFactor"], 1.0f);
  EXPECT_EQ(green["pbrMetallicRoughness"]["roughnessFactor"], 0.25f);
  EXPECT_EQ(green["emissiveFactor"], Json::array({0.0f, 0.0f, 1.0f}));
  EXPECT_EQ(green["emissiveTexture"]["index"], 0);
  EXPECT_EQ(json["materials"][2]["name"], "nowhere");
  EXPECT_EQ(green["normalTexture"]["index"], 1);
  EXPECT_EQ(json["images"], Json::array({Json{{"uri", "images/a%20b.png"}}, Json{{"uri", "bumps.png"}}}));
  EXPECT_EQ(json["textures"], Json::array({Json{{"source", 0}}, Json{{"source", 1}}}));
  EXPECT_EQ(asset.document.source, folder / "asset.obj");
  EXPECT_EQ(asset.document.files,
            (std::vector<std::filesystem::path>{folder / "the colours.mtl", folder / "asset.obj"}));
  const std::string warnings = warnings_of(asset);
  for (const char* said : {"the texture \"/etc/passwd.png\" is left out",
                           "1 line of the materials is not understood", "1 material is in no library"})
    EXPECT_TRUE(contains(warnings, said)) << said << "\n" << warnings;
}

TEST(Obj, TexturesArePlacedAndBumpMapsAreNormals) {
  const TestFolder folder;
  const auto png = [](char color_type) {
    return std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x08", 25) + color_type;
  };
  std::ofstream(folder / "grey.png") << png(0);
  std::ofstream(folder / "colour.png") << png(2);
  std::ofstream(folder / "a.mtl")
      << "newmtl a\nmap_Kd -o 0.25 0.5 0 -s 2 4 1 k.png\nmap_Bump -bm 0.5 colour.png\n"
         "newmtl b\nbump grey.png\nmap_Ke -clamp on -s 3 k.png\n"
         "newmtl c\nnorm colour.png\nmap_bump grey.png\nrefl sky.png\n";
  std::ofstream(folder / "a.obj") << "mtllib a.mtl\n" + kSquare +
                                         "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n";
  const Asset asset = must(read_asset(folder / "a.obj", describe_stream));
  const Json& json = asset.document.json();
  const Json& a = json["materials"][0];
  // MTL: (u, v) -> (2 u + 0.25, 4 v + 0.5), with v from the bottom.
  EXPECT_EQ(a["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"],
            (Json{{"offset", {0.25, -3.5}}, {"scale", {2.0, 4.0}}}));
  EXPECT_EQ(a["normalTexture"]["scale"], 0.5);
  EXPECT_EQ(json["materials"][1]["emissiveTexture"]["extensions"]["KHR_texture_transform"],
            (Json{{"scale", {3.0, 1.0}}}));
  EXPECT_EQ(json["images"][json["materials"][1]["normalTexture"]["index"].get<size_t>()]["uri"], "grey.png");
  EXPECT_EQ(json["materials"][2]["normalTexture"]["index"], a["normalTexture"]["index"]);
  EXPECT_EQ(json["extensionsUsed"], Json::array({"KHR_texture_transform"}));
  EXPECT_EQ(
      warnings_of(asset),
      "some options of textures are left out\ntextures of \"refl\" are left out: glTF has no such textures\n"
      "the bump map \"grey.png\" is grey, so it looks like heights; glTF takes it for normals\n");
}

TEST(Obj, LibrariesAreTextOfAnyProgram) {
  const TestFolder folder;
  std::string material = "newmtl red\r\nKd 1 0 0\r\n", wide = "\xFF\xFE";
  for (const char c : material) wide += {c, '\0'};
  std::ofstream(folder / "marked.mtl", std::ios::binary) << "\xEF\xBB\xBF" << material;
  std::ofstream(folder / "wide.mtl", std::ios::binary) << wide;
  std::ofstream(folder / "empty.mtl");
  const auto read = [&](const std::string& library) {
    std::ofstream(folder / "asset.obj") << "mtllib " + library + "\n" + kSquare + "usemtl red\nf 1 2 3\n";
    return read_asset(folder / "asset.obj", describe_stream);
  };
  const Expected<Asset> marked = read("marked.mtl");
  EXPECT_EQ(must(marked).document.json()["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"],
            Json::array({1.0f, 0.0f, 0.0f, 1.0f}));
  EXPECT_EQ(warnings_of(marked), "");
  EXPECT_EQ(warnings_of(read("wide.mtl")),
            "the library of materials \"wide.mtl\" is not read: text in UTF-16, and only UTF-8 is read: save "
            "it as UTF-8\n"
            "1 material is in no library: it gets only its name\n");
  EXPECT_TRUE(contains(warnings_of(read("empty.mtl")), "is not read: the file is empty\n"));
}

TEST(Obj, LibrariesStayBesideTheFile) {
  const TestFolder folder;
  std::filesystem::create_directories(folder / "inner");
  std::ofstream(folder / "outer.mtl") << "newmtl m\nKd 1 0 0\n";
  for (const char* library : {"none.mtl", "../outer.mtl", "/etc/passwd", "a.mtl b.mtl"}) {
    std::ofstream(folder / "inner" / "asset.obj")
        << "mtllib " << library << "\nusemtl m\n" + kSquare + "f 1 2 3\n";
    const Asset asset = must(read_asset(folder / "inner" / "asset.obj", describe_stream));
    EXPECT_EQ(warnings_of(asset),
              "the library of materials \"" + std::string(library) +
                  "\" cannot be read\n1 material is in no library: it gets only its name\n");
    EXPECT_EQ(asset.document.json()["materials"][0]["name"], "m");
  }
}

TEST(Obj, ColoursOfVerticesAreKeptWhereAllHaveThem) {
  const Mesh mesh = mesh_of(read_text("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3"));
  EXPECT_EQ(floats_of(mesh, "COLOR_0"), (std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  const Expected<Asset> some = read_text("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 0 0 1\nf 1 2 3");
  EXPECT_EQ(mesh_of(some).find("COLOR_0"), nullptr);
  EXPECT_EQ(warnings_of(some), "some vertices have no colours: all colours are left out\n");
}

TEST(Obj, VerticesMayFollowTheirFaces) {
  EXPECT_EQ(mesh_of(read_text("f 1/1 2/1 3/1\n" + kSquare + "vt 0 0")).faces.size(), 1u);
}

TEST(Obj, WhatIsLeftOutIsSaid) {
  const Expected<Asset> asset = read_text(
      kSquare +
      "vn 0 0 1\nvn 0 0 0\nvn 0 2 0\nf 1//1 2//2 3//3\nf 1 2\nl 1 2\np 1\ncurv 1 2\nf 1//9 2//1 3//1\n");
  EXPECT_EQ(warnings_of(asset),
            "1 face of fewer than 3 corners is left out\n2 lines and points are left out\n"
            "lines that begin with \"curv\" are left out\n"
            "1 corner names a normal that does not exist: its face gets none\n"
            "1 normal was not of unit length: normalized\n"
            "1 normal had no direction: made from the faces around it\n");
  EXPECT_EQ(floats_of(mesh_of(asset), "NORMAL"), (std::vector<float>{0, 0, 1, 0, 0, 1, 0, 1, 0}));
}

TEST(Obj, ErrorsSayWhere) {
  EXPECT_EQ(message_of(kSquare + "f 1 2 5\n"), "line 5: a face names vertex 5, but there are 4");
  EXPECT_EQ(message_of(kSquare + "f 1 2 0\n"),
            "line 5: a face names vertex 0, but vertices are counted from 1");
  EXPECT_EQ(message_of(kSquare + "f 1 2 -5\n"), "line 5: a face names vertex -5, but there are 4 before it");
  EXPECT_EQ(message_of(kSquare + "f 1 2 x\n"), "line 5: \"x\" is not a vertex number");
  EXPECT_EQ(message_of(kSquare + "f 1 2 99999999999999999999\n"),
            "line 5: \"99999999999999999999\" is not a vertex number");
  EXPECT_EQ(message_of(kSquare + "f 1 2 -9223372036854775808\n").substr(0, 20), "line 5: a face names");
  EXPECT_EQ(message_of("v 1 2\n"), "line 1: a vertex of fewer than 3 numbers");
  EXPECT_EQ(message_of("v 1 2 3,5\n"), "line 1: \"3,5\" is not a number");
  EXPECT_EQ(message_of("v 1 2 inf\n"), "line 1: a position that is not finite");
  EXPECT_EQ(message_of("v 1 2 3\n\x01\x02\n"), "line 2: \"??\" is not a statement of OBJ");
  EXPECT_EQ(message_of(kSquare, "a.obj", StatusCode::kUnsupported),
            "has no triangles: only a .drc file is made of points");
}

// An object takes few bytes of OBJ but many bytes of JSON.
TEST(Obj, MoreObjectsThanTheBytesJustifyAreRefused) {
  std::string file = kSquare;
  for (int i = 0; i < 20000; ++i) file += "o" + std::string(" ") + std::to_string(i) + "\nf 1 2 3\n";
  EXPECT_TRUE(contains(message_of(file, "a.obj", StatusCode::kUnsupported), "are too many"));
}

TEST(Obj, NamesInAnyEncodingBecomeUtf8) {
  const Asset asset = must(read_text(kSquare + "o gr\xfcn\nusemtl \xff\nf 1 2 3\no gr\xc3\xbcn2\nf 1 2 3"));
  EXPECT_EQ(asset.document.json()["meshes"][0]["name"], "gr\xc3\xbcn");
  EXPECT_EQ(asset.document.json()["meshes"][1]["name"], "gr\xc3\xbcn2");
  EXPECT_EQ(asset.document.json()["materials"][0]["name"], "\xc3\xbf");
}

TEST(Mtl, PathsBecomeUris) {
  EXPECT_EQ(uri_of_path("a b\\c%.png"), "a%20b/c%25.png");
  EXPECT_EQ(uri_of_path("../a.png"), "../a.png");
  EXPECT_EQ(uri_of_path("C:\\a.png"), "");
  EXPECT_EQ(uri_of_path("/a.png"), "");
}

}  // namespace
}  // namespace psplit
