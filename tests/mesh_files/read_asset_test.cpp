// Formats are recognized by content, gzip files are unpacked, and every loss is reported.
#include "mesh_files/read_asset.h"

#include <zlib.h>

#include <fstream>

#include "psplit/decode.h"
#include "psplit/document.h"
#include "tests/mesh_files/mesh_text.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

std::string gzip(const std::string& text) {
  z_stream state{};
  EXPECT_EQ(deflateInit2(&state, 1, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
  std::string packed(deflateBound(&state, static_cast<uLong>(text.size())), '\0');
  state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  state.avail_in = static_cast<uInt>(text.size());
  state.next_out = reinterpret_cast<Bytef*>(packed.data());
  state.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&state, Z_FINISH), Z_STREAM_END);
  packed.resize(state.total_out);
  deflateEnd(&state);
  return packed;
}

const std::string kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const std::string kOff = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const std::string kStl =
    "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
    "0\nendloop\nendfacet\nendsolid\n";

std::string gltf() {
  const TestFolder folder;
  EXPECT_TRUE(write_document(document_from_mesh(make_grid(2, 2)), folder / "a.glb").ok());
  std::ifstream file(folder / "a.glb", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A triangle in JSON.
std::string text_of_gltf() {
  return R"({"asset": {"version": "2.0"}, "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "data:,)" +
         std::string("%00%00%00%00%00%00%00%00%00%00%00%00%00%00%80%3F%00%00%00%00%00%00%00%00") +
         "%00%00%00%00%00%00%80%3F%00%00%00%00\"}]}";
}

const std::string kMark = "\xEF\xBB\xBF";

TEST(ReadAsset, ContentTellsTheFormatWhateverTheName) {
  for (const std::string& file : {kObj, kOff, kPly, kStl, gltf()})
    for (const std::string name :
         {"-", "asset", "a.ply", "a.obj", "a.stl", "a.off", "a.glb", "a.drc", "a.txt.gz"}) {
      EXPECT_TRUE(read_text(file, name).ok()) << name << read_text(file, name).status().to_string();
      EXPECT_TRUE(read_text(gzip(file), name).ok()) << name;
      EXPECT_EQ(read_text(file, name)->document.source, name);
    }
}

TEST(ReadAsset, ByteOrderMarksAreSkippedInEveryText) {
  const std::string triangle = text_of_gltf();
  for (const std::string& file : {kObj, kOff, kPly, kStl, triangle, "mtllib none.mtl\n" + kObj, "\r\n" + kStl})
    for (const char* name : {"-", "a.obj", "a.stl", "a.txt"})
      for (const std::string& text : {kMark + file, gzip(kMark + file)})
        EXPECT_EQ(mesh_of(read_text(text, name)).faces.size(), 1u) << file << name;
  // The bytes of a mark are data where the size says that the file is binary.
  std::string stl(84 + 50, '\0');
  stl.replace(0, 3, kMark);
  stl[80] = 1;
  stl[84 + 12] = stl[84 + 28] = 64;
  EXPECT_EQ(mesh_of(read_text(stl, "a.stl")).faces.size(), 1u);
}

TEST(ReadAsset, NormalsThatAreNoNumbersAreMadeFromTheFaces) {
  for (const std::string nan : {"-1.#IND", "1.#QNAN", "-nan(ind)", "1.#INF", "-1.#J", "nan"}) {
    const std::string vector = nan + " " + nan + " " + nan;
    std::string ply = kPly;
    ply.replace(ply.find("element face"), 0, "property float nx\nproperty float ny\nproperty float nz\n");
    ply.replace(ply.find("0 0 0\n1 0 0\n0 1 0\n"), 18, "0 0 0 " + vector + "\n1 0 0 0 0 1\n0 1 0 0 0 1\n");
    const std::string files[] = {
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn " + vector + "\nvn 0 0 1\nf 1//1 2//2 3//2\n", ply,
        "NOFF\n3 1 0\n0 0 0 " + vector + "\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
        "solid\nfacet normal " + vector +
            "\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
            "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
            "0\nendloop\nendfacet\nendsolid\n"};
    for (const std::string& file : files) {
      const Expected<Asset> asset = read_text(file);
      const std::vector<float> normals = floats_of(mesh_of(asset), "NORMAL");
      ASSERT_GE(normals.size(), 9u) << file;
      for (size_t i = 0; i < normals.size(); ++i) EXPECT_EQ(normals[i], i % 3 == 2 ? 1 : 0) << file;
      EXPECT_TRUE(contains(warnings_of(asset), "made from the faces around")) << file;
    }
    EXPECT_EQ(message_of("v 0 0 " + nan + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
              "line 1: a position that is not finite");
  }
}

TEST(ReadAsset, OtherEncodingsAreNamed) {
  const auto wide = [](const std::string& text, size_t width, bool big_endian) {
    std::string units;
    for (const char c : text) {
      std::string unit(width, '\0');
      unit[big_endian ? width - 1 : 0] = c;
      units += unit;
    }
    return units;
  };
  const std::string gltf_text = text_of_gltf();
  for (const std::string& file : {kObj, kOff, kPly, kStl, gltf_text})
    for (const bool big_endian : {false, true})
      for (const size_t width : {size_t{2}, size_t{4}}) {
        std::string mark = big_endian ? "\xFE\xFF" : "\xFF\xFE";
        mark.insert(big_endian ? 0 : 2, width - 2, '\0');
        for (const char* name : {"-", "a.obj", "a.stl", "a.gltf", "a.ply"})
          for (const std::string& text : {wide(file, width, big_endian), mark + wide(file, width, big_endian)})
            EXPECT_EQ(message_of(text, name, StatusCode::kUnsupported),
                      std::string("text in ") + (width == 2 ? "UTF-16" : "UTF-32") +
                          ", and only UTF-8 is read: save it as UTF-8");
      }
  const std::string gltf_wide = wide(gltf_text, 2, false);
  EXPECT_EQ(parse_document(bytes_of(gltf_wide), "a.gltf").status().code(), StatusCode::kUnsupported);
}

TEST(ReadAsset, TheNameDecidesWhereTheContentDoesNot) {
  EXPECT_EQ(read_text("hello", "a.txt").status().code(), StatusCode::kUnsupported);
  EXPECT_EQ(read_text("hello", "a.txt").status().message(),
            "a format that is not known; these are read: .gltf, .glb, .drc, .ply, .obj, .stl, .off");
  EXPECT_EQ(message_of("hello", "a.ply"), "line 1: it does not begin with \"ply\"");
  EXPECT_EQ(message_of("hello", "a.STL.gz"), "STL: the file ends inside its header");
  for (const char* name : {"a.ply", "a.glb", "a", "-"}) EXPECT_EQ(message_of("", name), "the file is empty");
  EXPECT_EQ(message_of(gzip("")), "the file is empty");
}

TEST(ReadAsset, NamesOfFormats) {
  for (const char* name : {"a.ply", "b/a.OBJ", "a.stl.gz", "a.Off.GZ", "a.glb", "a.gltf.gz", "a.drc"})
    EXPECT_TRUE(is_asset_name(name)) << name;
  for (const char* name : {"a.gz", "a.txt", "ply", "a.tar.gz", ""}) EXPECT_FALSE(is_asset_name(name)) << name;
  EXPECT_EQ(without_asset_extensions("b/a.x.ply.gz"), "b/a.x");
  EXPECT_EQ(without_asset_extensions("b/a.x.ply"), "b/a.x");
  EXPECT_EQ(without_asset_extensions("b/a.tar.gz"), "b/a.tar");
}

TEST(ReadAsset, GzipThatIsCutOrBrokenIsRefused) {
  for (const std::string& file : {kObj, kOff, kPly, kStl, gltf()}) {
    const std::string packed = gzip(file);
    for (size_t size = 3; size < packed.size(); ++size)
      EXPECT_EQ(message_of(packed.substr(0, size), "a.obj"), "gzip: the file ends early") << size;
    for (size_t at = packed.size() - 8; at < packed.size(); ++at) {
      std::string broken = packed;  // the checksum or the size is wrong
      broken[at] = static_cast<char>(broken[at] ^ 1);
      EXPECT_EQ(message_of(broken, "a.obj").substr(0, 5), "gzip:") << at;
    }
  }
  // Several members, and padding with zeros.
  EXPECT_TRUE(read_text(gzip(kObj.substr(0, 20)) + gzip(kObj.substr(20)) + std::string(100, '\0')).ok());
}

TEST(ReadAsset, GzipThatUnpacksToFarMoreIsRefused) {
  std::string vertices;
  while (vertices.size() < (size_t{80} << 20)) vertices += "v 0 0 0\n";
  EXPECT_EQ(message_of(gzip(vertices)), "gzip: unpacks to over 100 times its bytes");
  // This takes no memory either.
  EXPECT_EQ(message_of(gzip(std::string(size_t{80} << 20, '#')), "a.obj"),
            "gzip: unpacks to over 100 times its bytes");
}

TEST(ReadAsset, ErrorsNameTheFileOnce) {
  const TestFolder folder;
  const std::string missing = (folder / "none.ply").string();
  EXPECT_EQ(read_asset(missing, describe_stream).status().code(), StatusCode::kIo);
  EXPECT_EQ(read_asset(folder, describe_stream).status().code(), StatusCode::kIo);
  EXPECT_EQ(read_text("v 1 2\n", "a.obj").status().to_string(),
            "a.obj: line 1: a vertex of fewer than 3 numbers");
  EXPECT_EQ(read_text("v 1 2\n", "-").status().to_string(), "stdin: line 1: a vertex of fewer than 3 numbers");
}

TEST(ReadAsset, NormalsOfGltfThatAreNotOfUnitLengthAreCountedAndKept) {
  Mesh mesh = make_grid(2, 2);
  Attribute normals{"NORMAL", ComponentType::kFloat32, 3, false, {}};
  normals.values.resize(12 * mesh.point_count);
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const float normal[3] = {0, 0, i < 2 ? 2.0f : 1.0f};
    std::memcpy(normals.values.data() + 12 * i, normal, 12);
  }
  mesh.attributes.push_back(std::move(normals));
  const TestFolder folder;
  ASSERT_TRUE(write_document(document_from_mesh(mesh), folder / "a.glb").ok());
  const Expected<Asset> asset = read_asset(folder / "a.glb", describe_stream);
  EXPECT_EQ(warnings_of(asset), "2 normals are not of unit length, and kept so\n");
  EXPECT_EQ(floats_of(mesh_of(asset), "NORMAL")[2], 2);
}

}  // namespace
}  // namespace psplit
