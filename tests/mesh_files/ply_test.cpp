#include "mesh_files/ply.h"

#include "tests/mesh_files/mesh_text.h"

namespace psplit {
namespace {

constexpr const char* kXyz = "property float x\nproperty float y\nproperty float z\n";

std::string header(const std::string& format, int vertices, const std::string& vertex, int faces,
                   const std::string& face = "property list uchar int vertex_indices\n") {
  return "ply\nformat " + format + " 1.0\ncomment made by a test\nelement vertex " + std::to_string(vertices) +
         "\n" + vertex + "element face " + std::to_string(faces) + "\n" + face + "end_header\n";
}

const char* const kTypes[] = {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};

// Appends a number as binary PLY files store it.
void append(std::string& bytes, const std::string& type, double value, bool big_endian) {
  const auto put = [&](auto stored) {
    std::string raw(sizeof(stored), '\0');
    std::memcpy(raw.data(), &stored, sizeof(stored));
    if (big_endian) std::reverse(raw.begin(), raw.end());
    bytes += raw;
  };
  if (type == "char") put(static_cast<int8_t>(value));
  if (type == "uchar") put(static_cast<uint8_t>(value));
  if (type == "short") put(static_cast<int16_t>(value));
  if (type == "ushort") put(static_cast<uint16_t>(value));
  if (type == "int") put(static_cast<int32_t>(value));
  if (type == "uint") put(static_cast<uint32_t>(value));
  if (type == "float") put(static_cast<float>(value));
  if (type == "double") put(value);
}

struct Form {
  const char* name;
  bool big_endian;
};
constexpr Form kForms[] = {{"ascii", false}, {"binary_little_endian", false}, {"binary_big_endian", true}};

// A number in one of the three encodings.
void put(std::string& file, const Form& form, const std::string& type, double value) {
  if (form.name[0] == 'a')
    file +=
        (type == "float" || type == "double" ? std::to_string(value) : std::to_string(int64_t(value))) + " ";
  else
    append(file, type, value, form.big_endian);
}
void end_line(std::string& file, const Form& form, const char* end = "\n") {
  if (form.name[0] == 'a') file += end;
}

TEST(Ply, EveryEncodingAndEveryTypeSaysTheSame) {
  const double positions[] = {0, 0, 0, 3, 0, 0, 3, 2, 0, 0, 2, 1};
  for (const Form& form : kForms)
    for (const std::string position : kTypes)
      for (const std::string count : {"uchar", "ushort", "int"})
        for (const std::string index : {"char", "uchar", "short", "ushort", "int", "uint"}) {
          std::string file =
              header(form.name, 4,
                     "property " + position + " x\nproperty " + position + " y\nproperty " + position + " z\n",
                     2, "property list " + count + " " + index + " vertex_index\n");
          for (int i = 0; i < 12; ++i) {
            put(file, form, position, positions[i]);
            if (i % 3 == 2) end_line(file, form);
          }
          for (const std::vector<int>& face : {std::vector{0, 1, 2}, {3, 0, 1, 2}}) {
            put(file, form, count, static_cast<double>(face.size()));
            for (const int corner : face) put(file, form, index, corner);
            end_line(file, form, "\r\n");
          }
          const Expected<Asset> asset = read_text(file);
          const Mesh mesh = mesh_of(asset);
          EXPECT_EQ(warnings_of(asset), "");
          ASSERT_EQ(mesh.point_count, 4u);
          EXPECT_EQ(floats_of(mesh, "POSITION"), std::vector<float>(positions, positions + 12));
          const Array<std::array<uint32_t, 3>> expected = {{0, 1, 2}, {3, 0, 1}, {3, 1, 2}};
          EXPECT_EQ(mesh.faces, expected);
        }
}

TEST(Ply, NormalsColoursTexcoordsAndAllElseAreKept) {
  const std::string vertex =
      std::string(kXyz) +
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
      "property float s\nproperty float t\nproperty double quality\nproperty short label\n";
  for (const Form& form : kForms) {
    std::string file = header(form.name, 3, vertex, 1);
    for (int i = 0; i < 3; ++i) {
      for (const double value : {double(i), double(i * i), 1.0, 0.0, 0.0, 2.0}) put(file, form, "float", value);
      for (const int value : {255, 0, 10 * i, 128}) put(file, form, "uchar", value);
      put(file, form, "float", 0.25);
      put(file, form, "float", 0.75);
      put(file, form, "double", 0.5 + i);
      put(file, form, "short", -i);
      end_line(file, form);
    }
    put(file, form, "uchar", 3);
    for (int i = 0; i < 3; ++i) put(file, form, "int", i);
    const Expected<Asset> asset = read_text(file);
    const Mesh mesh = mesh_of(asset);
    EXPECT_EQ(floats_of(mesh, "NORMAL"), (std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}));
    EXPECT_EQ(floats_of(mesh, "TEXCOORD_0"), (std::vector<float>{0.25f, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f}));
    EXPECT_EQ(floats_of(mesh, "_QUALITY"), (std::vector<float>{0.5f, 1.5f, 2.5f}));
    const Attribute* color = mesh.find("COLOR_0");
    ASSERT_NE(color, nullptr);
    EXPECT_EQ(color->component_type, ComponentType::kUint8);
    EXPECT_TRUE(color->normalized);
    EXPECT_EQ(color->values[4 * 2 + 2], std::byte{20});
    const Attribute* label = mesh.find("_LABEL");
    ASSERT_NE(label, nullptr);
    EXPECT_EQ(label->component_type, ComponentType::kInt16);
    EXPECT_EQ(warnings_of(asset),
              "other properties of vertices become attributes: _QUALITY, _LABEL\n"
              "3 normals were not of unit length: normalized\n");
  }
}

TEST(Ply, PolygonsOfAnySizeAndStripsBecomeTriangles) {
  for (const int corners : {3, 4, 9, 67, 936, 1000}) {
    std::string file = header("ascii", corners, kXyz, 1, "property list ushort int vertex_indices\n");
    for (int i = 0; i < corners; ++i) {
      const double angle = 6.283185307 * i / corners, radius = i % 2 == 0 ? 2 : 1.5;
      file +=
          std::to_string(radius * std::cos(angle)) + " 5 " + std::to_string(radius * std::sin(angle)) + "\n";
    }
    file += std::to_string(corners);
    for (int i = 0; i < corners; ++i) file += " " + std::to_string(i);
    const Mesh mesh = mesh_of(read_text(file));
    EXPECT_EQ(mesh.faces.size(), static_cast<size_t>(corners - 2));
    if (corners % 2 == 0) {
      EXPECT_NEAR(area_of(mesh), corners / 2 * 2 * 1.5 * std::sin(6.283185307 / corners), 1e-4);
    }
  }
  std::string strips = "ply\nformat ascii 1.0\nelement vertex 5\n" + std::string(kXyz) +
                       "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                       "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 4 -1 0 1 2\n";
  const Array<std::array<uint32_t, 3>> expected = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {0, 1, 2}};
  EXPECT_EQ(mesh_of(read_text(strips)).faces, expected);
}

TEST(Ply, WhatIsLeftOutIsSaid) {
  const std::string file =
      "ply\r\nformat ascii 1.0\r\nelement camera 1\r\nproperty float f\r\nelement vertex 3\r\n"
      "property list uchar int neighbours\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
      "element face 3\r\nproperty uchar red\r\nproperty list uchar int vertex_indices\r\nend_header\r\n"
      "1.5\r\n2 7 8 0 0 0\r\n0 1 0 0\r\n1 9 0 1 0\r\n200 3 0 1 2\r\n3 2 0 1\r\n3 1 0";
  const Expected<Asset> asset = read_text(file);
  EXPECT_EQ(mesh_of(asset).faces.size(), 1u);
  EXPECT_EQ(warnings_of(asset),
            "the elements \"camera\" are left out\n"
            "the lists \"neighbours\" of vertices are left out\n"
            "other properties of faces are left out: \"red\"\n"
            "2 faces of fewer than 3 corners are left out\n");
}

TEST(Ply, ErrorsSayWhere) {
  const std::string three = "0 0 0\n1 0 0\n0 1 0\n";
  const auto text = [&](const std::string& body, int faces = 1) {
    return header("ascii", 3, kXyz, faces) + body;
  };
  EXPECT_EQ(message_of(text(three + "3 0 1 3\n")), "line 14: a face names vertex 3, but there are 3");
  EXPECT_EQ(message_of(text(three + "3 0 1 -1\n")), "line 14: a face names vertex -1, but there are 3");
  EXPECT_EQ(message_of(text("0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n")),
            "line 12: the position of vertex 1 is not finite");
  EXPECT_EQ(message_of(text("0 0 0\n1 0 1e99\n0 1 0\n3 0 1 2\n")), "line 12: \"1e99\" is not a number");
  EXPECT_EQ(message_of(text("0 0 0\n1 0\n0 1 0\n3 0 1 2\n")), "line 13: \"1\" is more than the header states");
  EXPECT_EQ(message_of(text(three + "3 0 1 2 7\n")), "line 14: \"7\" is more than the header states");
  EXPECT_EQ(message_of(text(three + "3 0 1 2\n3 0 1 2\n")), "line 15: \"3\" is more than the header states");
  EXPECT_EQ(message_of(text(three + "300 0 1 2\n")), "line 14: \"300\" is out of its type's range");
  EXPECT_EQ(message_of(text(three + "3 0 1 x\n")), "line 14: \"x\" is not a number");
  EXPECT_EQ(message_of(text(three + "3 0 1 1.5\n")), "line 14: \"1.5\" is not a whole number");
  EXPECT_EQ(message_of("ply\nformat ascii 2.0\nend_header\n"), "line 2: PLY \"2.0\" is not version 1.0");
  EXPECT_EQ(message_of("ply\nelement vertex 1\nproperty what x\n"), "line 3: \"what\" is not a type of PLY");
  EXPECT_EQ(message_of("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\n1\n2\n3\n"),
            "line 6: vertices without x, y and z");
  // A count that the bytes cannot hold is refused before anything is read or allocated.
  const std::string claims = header("binary_little_endian", 2000000000, kXyz, 1) + std::string(100, '\0');
  EXPECT_TRUE(
      contains(message_of(claims),
               "claims 2000000000 elements \"vertex\", which take 12 bytes each or more, and 100 bytes"));
  EXPECT_EQ(message_of(header("ascii", 1, kXyz, 0) + "0 0 0\n", "test", StatusCode::kUnsupported),
            "has no triangles: only a .drc file is made of points");
}

TEST(Ply, EveryTruncationIsRefused) {
  for (const Form& form : kForms) {
    std::string file = header(form.name, 4, kXyz, 2);
    for (int i = 0; i < 12; ++i) {
      put(file, form, "float", i % 4);
      if (i % 3 == 2) end_line(file, form);
    }
    for (int face = 0; face < 2; ++face) {
      put(file, form, "uchar", 3);
      for (int i = 0; i < 3; ++i) put(file, form, "int", i + face);
      end_line(file, form);
    }
    ASSERT_TRUE(read_text(file).ok()) << read_text(file).status().to_string();
    const bool text = form.name[0] == 'a';
    // The space and the end of the line after the last number of a text do not matter.
    for (size_t size = 0; size + (text ? 2 : 0) < file.size(); ++size)
      EXPECT_FALSE(read_text(file.substr(0, size), "test.ply").ok()) << form.name << " " << size;
  }
}

// A byte 10 after the header is data, not the end of a line.
TEST(Ply, BinaryDataBeginRightBehindTheHeader) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string file;
    for (const char c : header("binary_little_endian", 3, kXyz, 1)) file += c == '\n' ? end : std::string(1, c);
    std::string data;
    for (int i = 0; i < 9; ++i) append(data, "float", i, false);
    data[0] = '\n';
    file += data;
    append(file, "uchar", 3, false);
    for (int i = 0; i < 3; ++i) append(file, "int", i, false);
    const Mesh mesh = mesh_of(read_text(file));
    ASSERT_EQ(mesh.faces.size(), 1u) << testing::PrintToString(end);
    EXPECT_EQ(floats_of(mesh, "POSITION")[8], 8);
  }
}

TEST(Ply, SaysWhichWholeNumbersAreNoFloats) {
  for (const char* rest : {"", " 0"})
    for (const auto& [type, number] :
         {std::pair{"int", "-16777217"}, {"uint", "4294967295"}, {"int", "16777217"}}) {
      const std::string vertex =
          std::string(kXyz) + "property " + type + " id\n" + (*rest == 0 ? "" : "property double other\n");
      std::string file = header("ascii", 3, vertex, 1);
      for (const char* point : {"0 0 0 ", "1 0 0 ", "0 1 0 "})
        file += std::string(point) + (point[0] == '1' ? number : "16777216") + rest + "\n";
      file += "3 0 1 2\n";
      EXPECT_TRUE(
          contains(warnings_of(read_text(file)), "1 whole number of _ID is rounded: no float is equal to it\n"))
          << warnings_of(read_text(file));
    }
  const std::string vertex = std::string(kXyz) + "property int id\n";
  const std::string file = header("ascii", 3, vertex, 1) + "0 0 0 1\n1 0 0 16777216\n0 1 0 -7\n3 0 1 2\n";
  EXPECT_EQ(warnings_of(read_text(file)), "other properties of vertices become attributes: _ID\n");
}

const char* const kTexturedFace =
    "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n";

TEST(Ply, TextureFilesBecomeMaterials) {
  const std::string vertex = std::string(kXyz) + "property float s\nproperty float t\n";
  std::string file = header("ascii", 3, vertex, 1) + "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
  file.insert(file.find("element"), "comment TextureFile the image.png\n");
  const Expected<Asset> asset = read_text(file);
  EXPECT_EQ(warnings_of(asset), "");
  const Json& json = asset->document.json();
  EXPECT_EQ(json["meshes"][0]["primitives"][0]["material"], 0);
  EXPECT_EQ(json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  EXPECT_EQ(json["images"][0]["uri"], "the%20image.png");
  // Formats that glTF does not have, and textures without coordinates, are left out.
  std::string other = file;
  other.replace(other.find("png"), 3, "tga");
  EXPECT_EQ(warnings_of(read_text(other)),
            "the texture \"the image.tga\" is left out: glTF allows relative paths of .png and .jpg files\n");
  std::string bare = header("ascii", 3, kXyz, 1) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  bare.insert(bare.find("element"), "comment TextureFile a.png\n");
  const Expected<Asset> without = read_text(bare);
  EXPECT_EQ(warnings_of(without), "textures are left out: there are no texture coordinates\n");
  EXPECT_FALSE(without->document.json().contains("materials"));
}

// A square of two triangles and a quad; the second triangle has other coordinates on the shared edge.
TEST(Ply, TexcoordsOfFacesBecomeSeams) {
  for (const Form& form : kForms) {
    std::string file = header(form.name, 5, std::string(kXyz) + "property uchar label\n", 3, kTexturedFace);
    file.insert(file.find("element"), "comment TextureFile a.png\ncomment TextureFile b.jpg\n");
    const int positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 9, 9, 9};
    for (int i = 0; i < 5; ++i) {
      for (int axis = 0; axis < 3; ++axis) put(file, form, "float", positions[3 * i + axis]);
      put(file, form, "uchar", 10 + i);
      end_line(file, form);
    }
    const auto face = [&](const std::vector<int>& corners, const std::vector<double>& texcoords, int texture) {
      put(file, form, "uchar", static_cast<double>(corners.size()));
      for (const int corner : corners) put(file, form, "int", corner);
      put(file, form, "uchar", static_cast<double>(texcoords.size()));
      for (const double value : texcoords) put(file, form, "float", value);
      put(file, form, "int", texture);
      end_line(file, form);
    };
    face({0, 1, 2}, {0, 0, 1, 0, 1, 1}, 0);
    face({0, 2, 3}, {0, 0, 0.5, 0.5, 0, 1}, 0);
    face({3, 2, 1, 0}, {0, 0, 1, 0, 1, 1, 0, 0.25}, 1);
    const Expected<Asset> asset = read_text(file);
    EXPECT_EQ(warnings_of(asset),
              "other properties of vertices become attributes: _LABEL\n1 vertex without a face is left out\n");
    const Mesh first = mesh_of(asset, {0, 0}), second = mesh_of(asset, {0, 1});
    EXPECT_EQ(first.point_count, 5u);  // 0, 1, 2 twice, 3
    ASSERT_EQ(first.faces.size(), 2u);
    EXPECT_EQ(first.faces[0][0], first.faces[1][0]);
    EXPECT_NE(first.faces[0][2], first.faces[1][1]);
    const std::vector<float> texcoords = floats_of(first, "TEXCOORD_0");
    EXPECT_EQ(texcoords[2 * first.faces[0][2]], 1.0f);
    EXPECT_EQ(texcoords[2 * first.faces[1][1]], 0.5f);
    EXPECT_EQ(texcoords[2 * first.faces[1][2] + 1], 0.0f);
    const Attribute& label = *first.find("_LABEL");
    EXPECT_EQ(label.values[first.faces[0][2]], std::byte{12});
    EXPECT_EQ(label.values[first.faces[1][1]], std::byte{12});
    EXPECT_EQ(second.point_count, 4u);
    EXPECT_EQ(second.faces.size(), 2u);
    std::vector<float> v;
    for (size_t i = 1; i < 8; i += 2) v.push_back(floats_of(second, "TEXCOORD_0")[i]);
    EXPECT_EQ(v, (std::vector<float>{0.75f, 0, 1, 1}));
    const Json& primitives = asset->document.json()["meshes"][0]["primitives"];
    EXPECT_EQ(primitives[0]["material"], 0);
    EXPECT_EQ(primitives[1]["material"], 1);
    EXPECT_EQ(asset->document.json()["images"][1]["uri"], "b.jpg");
  }
}

TEST(Ply, FacesWithoutTexcoordsAreAPartOfTheirOwn) {
  std::string file = header("ascii", 4, kXyz, 3, kTexturedFace) + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  file += "3 0 1 2 6 0 0 1 0 0 1 7\n3 1 3 2 0 -1\n3 2 1 0 4 0 0 1 1 0\n";
  const Expected<Asset> asset = read_text(file);
  EXPECT_EQ(warnings_of(asset), "1 face has texture coordinates for another number of corners: left out\n");
  EXPECT_EQ(mesh_of(asset, {0, 0}).find("TEXCOORD_0"), nullptr);
  EXPECT_EQ(mesh_of(asset, {0, 0}).faces.size(), 2u);
  EXPECT_NE(mesh_of(asset, {0, 1}).find("TEXCOORD_0"), nullptr);
  EXPECT_FALSE(asset->document.json().contains("materials"));
}

TEST(Ply, CommentsOfBlenderMayLackTheirKeyword) {
  std::string file = header("ascii", 3, kXyz, 1) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  file.insert(file.find("element"), "Created by Blender3D 2.49 - www.blender.org, source file: a.blend\n");
  const Expected<Asset> asset = read_text(file);
  EXPECT_EQ(mesh_of(asset).faces.size(), 1u);
  EXPECT_EQ(warnings_of(asset), "");
}

}  // namespace
}  // namespace psplit
