#include "gltf_ext/document/document.h"

#include <fstream>

#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/primitive/accessors.h"
#include "psplit/document.h"
#include "system/files.h"
#include "system/uri.h"
#include "tests/support/environment.h"
#include "tests/support/expect.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

class DocumentTest : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  Expected<Document> read(const std::string& content) { return read_document(write("asset.gltf", content)); }
  StatusCode code(const std::string& content) { return read(content).status().code(); }

  TestFolder folder_;
};

std::string asset(const std::string& members) { return R"({"asset":{"version":"2.0"},)" + members + "}"; }

std::string glb(std::string json, const std::string& binary) {
  const auto head = glb_head(std::move(json), binary.size());
  return std::string(head->begin(), head->end()) + binary;
}

std::string text_of(std::span<const uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

constexpr const char* kOneView =
    R"("buffers":[{"byteLength":8}],"bufferViews":[{"buffer":0,"byteLength":8}],)"
    R"("accessors":[{"bufferView":0,"componentType":5121,"type":"VEC4","count":2}])";

TEST_F(DocumentTest, ReadsGlb) {
  const auto document = must(read(glb(asset(kOneView), "abcdefgh")));
  EXPECT_TRUE(document.from_glb);
  EXPECT_EQ(text_of(*buffer_view_bytes(document, 0)), "abcdefgh");
}

TEST_F(DocumentTest, SurvivesEveryByteOfAGlbChanged) {
  const std::string whole = glb(asset(kOneView), "abcdefgh");
  for (size_t i = 0; i < whole.size(); ++i) {
    for (const char bits : {'\x01', '\x20', '\x7f'}) {
      std::string changed = whole;
      changed[i] = static_cast<char>(changed[i] ^ bits);
      const auto document = read(changed);
      if (!document || document->records().accessors.empty()) continue;
      const auto data = read_accessor(*document, 0);
      if (data) {
        EXPECT_LE(data->values.size(), 8u * 16);
      }
    }
  }
}

TEST_F(DocumentTest, RefusesWrongGlbChunks) {
  const std::string whole = glb(asset(kOneView), "abcdefgh");
  std::string version = whole;
  version[4] = 1;
  EXPECT_EQ(code(version), StatusCode::kUnsupported);
  std::string not_json = whole;
  not_json[16] = 'X';
  EXPECT_EQ(code(not_json), StatusCode::kInvalidInput);
  std::string long_chunk = whole;
  long_chunk[15] = '\x7f';
  EXPECT_EQ(code(long_chunk), StatusCode::kInvalidInput);
  EXPECT_EQ(code(glb(asset(kOneView), "")), StatusCode::kInvalidInput);
  EXPECT_EQ(code(glb(asset(kOneView), "abcd")), StatusCode::kInvalidInput);
  // The header states the length of the file; the header of a chunk has eight bytes.
  const auto with_chunks = [&](const std::string& before, const std::string& after) {
    std::string file = whole.substr(0, whole.size() - 16) + before + whole.substr(whole.size() - 16) + after;
    file[8] = static_cast<char>(file.size());
    return read(file).status().message();
  };
  const std::string other("\4\0\0\0XYZWabcd", 12);
  ASSERT_LT(whole.size() + other.size(), 256u);
  EXPECT_EQ(with_chunks("", other), "");
  EXPECT_EQ(with_chunks(other, ""), "the GLB's binary chunk is not its second chunk");
  EXPECT_EQ(with_chunks("", std::string("\3\0\0\0XYZWabc", 11)), "a GLB chunk's length is not a multiple of 4");
}

TEST_F(DocumentTest, ToleratesAByteOrderMarkAndFloatsForIntegers) {
  EXPECT_TRUE(read("\xEF\xBB\xBF" + asset(R"("extras":0)")));
  EXPECT_TRUE(read(asset(R"("buffers":[{"byteLength":3.0,"uri":"data:;base64,AAAA"}])")));
}

TEST_F(DocumentTest, RefusesHostileJson) {
  for (const char* text : {"", "{", "[]", "null", "{}", "{\"asset\":2}", "{\"asset\":{}}", "\xff\xfe"})
    EXPECT_EQ(code(text), StatusCode::kInvalidInput) << text;
  EXPECT_EQ(code(std::string(1000000, '[')), StatusCode::kInvalidInput);
  const std::string deep = std::string(300, '[') + std::string(300, ']');
  EXPECT_EQ(code(asset("\"extras\":" + deep)), StatusCode::kInvalidInput);
  std::string wide = "\"extras\":{";
  for (int i = 0; i < 20000; ++i) wide += "\"" + std::to_string(i) + "\":0,";
  EXPECT_EQ(code(asset(wide + "\"x\":0}")), StatusCode::kInvalidInput);
  EXPECT_EQ(code(R"({"asset":{"version":"1.0"}})"), StatusCode::kUnsupported);
}

TEST_F(DocumentTest, RefusesWrongStructure) {
  const std::string buffer = R"("buffers":[{"byteLength":3,"uri":"data:;base64,AAAA"}],)";
  const std::string view = buffer + R"("bufferViews":[{"buffer":0,"byteLength":3}],)";
  ASSERT_TRUE(
      read(asset(view + R"("accessors":[{"bufferView":0,"componentType":5121,"type":"VEC3","count":1}])")));
  for (const std::string& members :
       {std::string(R"("accessors":{})"),
        std::string(R"("meshes":[1])"),
        std::string(R"("meshes":[{}])"),
        std::string(R"("meshes":[{"primitives":[{}]}])"),
        std::string(R"("extensionsUsed":[1])"),
        std::string(R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])"),
        std::string(R"("meshes":[{"primitives":[{"attributes":{},"targets":[1]}]}])"),
        std::string(R"("buffers":[{"byteLength":-1}])"),
        std::string(R"("buffers":[{"byteLength":1,"uri":3}])"),
        buffer + R"("bufferViews":[{"buffer":1,"byteLength":1}])",
        buffer + R"("bufferViews":[{"buffer":0,"byteLength":4}])",
        buffer + R"("bufferViews":[{"buffer":0,"byteLength":1,"byteOffset":9007199254740992}])",
        buffer + R"("bufferViews":[{"buffer":0,"byteLength":1,"byteOffset":-1}])",
        buffer + R"("bufferViews":[{"buffer":0,"byteLength":18446744073709551615}])",
        buffer + R"("bufferViews":[{"buffer":0,"byteLength":1,"byteStride":1000}])",
        view + R"("images":[{"bufferView":1}])",
        view + R"("images":[{"bufferView":"0"}])",
        view + R"("accessors":[{"bufferView":0,"componentType":5121,"type":"VEC3","count":2}])",
        view + R"("accessors":[{"bufferView":0,"componentType":5124,"type":"VEC3","count":1}])",
        view + R"("accessors":[{"bufferView":0,"componentType":5121,"type":"VEC5","count":1}])",
        view + R"("accessors":[{"bufferView":0,"componentType":5121,"type":"VEC3","count":4294967296}])",
        view + R"("accessors":[{"bufferView":0,"componentType":5121,"type":"VEC3","count":1.5}])",
        view + R"("accessors":[{"componentType":5121,"type":"VEC3","count":1,"sparse":{"count":1}}])"})
    EXPECT_EQ(code(asset(members)), StatusCode::kInvalidInput) << members;
}

TEST_F(DocumentTest, RefusesIndicesOfWhatDoesNotExistAndNodesBelowThemselves) {
  ASSERT_TRUE(
      read(asset(R"("scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"children":[2]},{"children":[2]},{}])")));
  for (const auto& [members, message] : std::vector<std::pair<std::string, std::string>>{
           {R"("scene":0)", "scene is not the index of one of the 0 scenes"},
           {R"("scenes":[{"nodes":[0]}])", "scenes[0].nodes[0] is not the index of one of the 0 nodes"},
           {R"("nodes":[{},{"children":[0,2]}])",
            "nodes[1].children[1] is not the index of one of the 2 nodes"},
           {R"("nodes":[{"mesh":-1}])", "nodes[0].mesh is not the index of one of the 0 meshes"},
           {R"("nodes":[{"camera":"a"}],"cameras":[{}])",
            "nodes[0].camera is not the index of one of the 1 cameras"},
           {R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}])",
            "materials[0].pbrMetallicRoughness.baseColorTexture.index is not the index of one of the 0 "
            "textures"},
           {R"("textures":[{"sampler":0}])", "textures[0].sampler is not the index of one of the 0 samplers"},
           {R"("animations":[{},{"samplers":[],"channels":[{"sampler":0}]}])",
            "animations[1].channels[0].sampler is not the index of one of the 0 samplers of the animation"},
           {R"("meshes":[{"primitives":[{"attributes":{},"material":1}]}],"materials":[{}])",
            "meshes[0].primitives[0].material is not the index of one of the 1 materials"},
           {R"("nodes":[{"children":[1]},{"children":[2]},{"children":[1]}])", "node 1 is its own descendant"},
           {R"("nodes":[{"children":[0]}])", "node 0 is its own descendant"},
           {R"("skins":[{"joints":[]}])", "skin 0 has no joints"},
           {R"("nodes":[{}],"skins":[{"joints":[0]},{"joints":[0,1]}])",
            "skins[1].joints[1] is not the index of one of the 1 nodes"},
           {R"("nodes":[{}],"skins":[{"joints":[0,0],"inverseBindMatrices":0}],)"
            R"("accessors":[{"componentType":5126,"type":"MAT4","count":1}])",
            "skin 0 has fewer inverse bind matrices than joints"}}) {
    const auto document = read(asset(members));
    EXPECT_EQ(document.status().code(), StatusCode::kInvalidInput) << members;
    EXPECT_EQ(document.status().message(), message) << members;
  }
}

TEST_F(DocumentTest, RefusesAttributesOfOtherTypes) {
  const std::string accessors =
      R"("accessors":[{"componentType":5126,"type":"VEC2","count":1},{"componentType":5126,"type":"VEC3","count":1},)"
      R"({"componentType":5121,"type":"VEC4","count":1}],)";
  const auto message = [&](const std::string& primitives) {
    const auto document = read(asset(accessors + R"("meshes":[{"primitives":[)" + primitives + "]}]"));
    return document ? "" : document.status().to_string().substr((folder_ / "asset.gltf").string().size());
  };
  EXPECT_EQ(message(R"({"attributes":{"POSITION":1,"NORMAL":1,"TEXCOORD_0":0,"COLOR_0":2,"_ANY":0}})"), "");
  EXPECT_EQ(message(R"({"attributes":{"JOINTS_0":2,"WEIGHTS_0":2}},{"attributes":{}})"), "");
  EXPECT_EQ(message(R"({"attributes":{"POSITION":0}})"), ": mesh 0, primitive 0: POSITION is of type VEC2");
  EXPECT_EQ(message(R"({"attributes":{}},{"attributes":{"TEXCOORD_1":1}})"),
            ": mesh 0, primitive 1: TEXCOORD_1 is of type VEC3");
  EXPECT_EQ(message(R"({"attributes":{"JOINTS_0":2}})"),
            ": mesh 0, primitive 0: the numbers of JOINTS and WEIGHTS attributes differ");
  EXPECT_EQ(message(R"({"attributes":{},"targets":[{}]},{"attributes":{},"targets":[{},{}]})"),
            ": mesh 0, primitive 1: 2 morph targets, but the mesh's first primitive has 1");
}

TEST_F(DocumentTest, LoadsUris) {
  const auto one = [&](const std::string& uri) {
    const auto document = read(asset(R"("buffers":[{"byteLength":3,"uri":")" + uri + "\"}]"));
    return document ? text_of(document->buffers[0])
                    : "status " + std::to_string(static_cast<int>(document.status().code()));
  };
  write("with space.bin", "abcdef");
  EXPECT_EQ(one("with%20space.bin"), "abc");
  EXPECT_EQ(one("with space.bin"), "abc");
  EXPECT_EQ(one("./with%20space.bin"), "abc");
  EXPECT_EQ(one("data:application/octet-stream;base64,YWJj"), "abc");
  EXPECT_EQ(one("data:;base64,YWJjZA=="), "abc");
  EXPECT_EQ(one("data:,a%62c"), "abc");
  EXPECT_EQ(one("data:;base64,YW"), "status 3");
  EXPECT_EQ(one("data:;base64,YW!j"), "status 3");
  EXPECT_EQ(one("data:nothing"), "status 3");
  for (const char* no_file : {"%00", ""}) EXPECT_EQ(one(no_file), "status 3") << no_file;
  // glTF allows these.
  for (const char* escape : {"../asset.gltf", "%2e%2e/asset.gltf", "x/../../y", "/etc/hostname", "..\\\\y"})
    EXPECT_EQ(one(escape), "status 5") << escape;
  EXPECT_EQ(one("https://example.com/a.bin"), "status 5");
  EXPECT_EQ(one("missing.bin"), "status 2");
  EXPECT_EQ(one("."), "status 2");
}

TEST_F(DocumentTest, WhatANewerMeshoptimizerCompressedPassesThrough) {
  const std::string text =
      asset(R"("buffers":[{"byteLength":4,"uri":"data:;base64,ogAAAA=="},)"
            R"({"byteLength":64,"extensions":{"EXT_meshopt_compression":{"fallback":true}}}],)"
            R"("bufferViews":[{"buffer":1,"byteLength":64,"extensions":{"EXT_meshopt_compression":)"
            R"({"buffer":0,"byteLength":4,"byteStride":4,"count":16,"mode":"ATTRIBUTES"}}}])");
  Expected<Document> read_one = read(text);
  if (contains(read_one.status().message(), "built without meshoptimizer"))
    GTEST_SKIP() << read_one.status().message();
  const auto document = must(std::move(read_one));
  EXPECT_EQ(buffer_view_bytes(document, 0).status().code(), StatusCode::kUnsupported);
  ASSERT_TRUE(write_document(document, folder_ / "out.glb").ok());
  const auto again = must(read_document(folder_ / "out.glb"));
  EXPECT_EQ(again.json(), document.json());
}

// A large buffer does not move for appended bytes, unless it would be dropped with its name.
TEST(Document, BytesAfterALargeBufferAreInANewOne) {
  for (const bool has_name : {false, true}) {
    Document document = new_document();
    append_buffer_view(document, std::vector<uint8_t>(kLargeBuffer, 7));
    if (has_name) document.json()["buffers"][0]["name"] = "geometry";
    const uint8_t* const before = document.buffers[0].data();
    append_buffer_view(document, std::vector<uint8_t>{1, 2, 3});
    EXPECT_EQ(document.buffers.size(), has_name ? 1u : 2u);
    EXPECT_EQ(document.json()["bufferViews"][1]["buffer"], has_name ? 0 : 1);
    EXPECT_TRUE(has_name || document.buffers[0].data() == before);
    EXPECT_EQ(buffer_view_bytes(document, 1)->size(), 3u);
  }
}

// A mapped input is read, edited and written like one in memory, also onto itself.
TEST_F(DocumentTest, AMappedFileIsLikeOneThatIsRead) {
  Document large = new_document();
  std::vector<uint8_t> bytes(kMappedBytes);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(i * i >> 7);
  for (const size_t size : {size_t{10}, bytes.size(), size_t{20}})
    append_buffer_view(large, std::span(bytes).first(size));
  large.json()["images"] = Json::array({Json{{"bufferView", 2}}, Json{{"bufferView", 1}}});
  for (const std::string name : {"large.glb", "large.gltf"}) {
    ASSERT_TRUE(write_document(large, folder_ / name).ok());
    Document read = *read_document(folder_ / name), mapped = *read_document(folder_ / name, FileAccess::kMap);
    EXPECT_FALSE(read.buffers[0].is_shared());
    EXPECT_TRUE(mapped.buffers[0].is_shared());
    EXPECT_EQ(mapped.json(), read.json());
    const auto expect_same_files = [&] {
      ASSERT_TRUE(write_document(read, folder_ / "read.glb").ok());
      ASSERT_TRUE(write_document(mapped, folder_ / name).ok());
      ASSERT_TRUE(write_document(mapped, folder_ / "mapped.glb").ok());
      EXPECT_EQ(*read_file(folder_ / "mapped.glb"), *read_file(folder_ / "read.glb")) << name;
    };
    expect_same_files();
    EXPECT_TRUE(mapped.buffers[0].is_shared());
    for (Document* document : {&read, &mapped}) drop_unused(*document, {});
    expect_same_files();
    mapped = *read_document(folder_ / name, FileAccess::kMap);
    EXPECT_TRUE(mapped.buffers[0].is_shared());
    for (Document* document : {&read, &mapped})
      document->json()["images"][0]["bufferView"] = append_buffer_view(*document, std::span(bytes).first(30));
    expect_same_files();
  }
}

TEST_F(DocumentTest, BufferWithoutUriLoadsWithoutBytes) {
  const auto document = must(read(asset(kOneView)));
  EXPECT_EQ(buffer_view_bytes(document, 0).status().code(), StatusCode::kUnsupported);
  EXPECT_EQ(read_accessor(document, 0).status().code(), StatusCode::kUnsupported);
}

TEST_F(DocumentTest, MergesBuffersOnWriting) {
  const std::string text =
      asset(R"("buffers":[{"byteLength":3,"uri":"data:,abc"},{"byteLength":3,"uri":"data:,def"}],)"
            R"("bufferViews":[{"buffer":1,"byteOffset":1,"byteLength":2},{"buffer":0,"byteLength":3}],)"
            R"("extras":{"z":[0.1,1e-300,3.4028234663852886e38,-0.0],"a":"\u00e9"})");
  const auto document = must(read(text));
  for (const char* name : {"out.glb", "out.gltf"}) {
    ASSERT_TRUE(write_document(document, folder_ / name).ok());
    const auto again = must(read_document(folder_ / name));
    EXPECT_EQ(again.buffers.size(), 1u);
    EXPECT_EQ(text_of(*buffer_view_bytes(again, 0)), "ef");
    EXPECT_EQ(text_of(*buffer_view_bytes(again, 1)), "abc");
    EXPECT_EQ(again.json()["extras"].dump(), document.json()["extras"].dump());
  }
  // The outputs are the only files: asset.gltf, out.glb, out.gltf and its .bin.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 4);
  EXPECT_EQ(write_document(document, folder_ / "out.obj").code(), StatusCode::kUsage);
  EXPECT_EQ(write_document(document, folder_ / "none" / "out.glb").code(), StatusCode::kIo);
}

// JSON in one line stays that, because lines would take more bytes.
TEST_F(DocumentTest, AGltfIsNotLaidOutLarger) {
  const std::string line =
      asset(R"("nodes":[{"name":"a","children":[1]},{"name":"b"}],"scenes":[{"nodes":[0]}])");
  for (const std::string& text : {line, json_lines(must(parse_json(line)))}) {
    ASSERT_TRUE(write_document(must(read(text)), folder_ / "out.gltf").ok());
    EXPECT_EQ(fs::file_size(folder_ / "out.gltf"), text.size());
  }
}

// The files of a folder with this extension.
std::vector<fs::path> files_ending(const fs::path& folder, const std::string& end) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().string().ends_with(end)) found.push_back(entry.path());
  return found;
}

// Whenever writing stops, the existing .gltf refers to its own bytes.
TEST_F(DocumentTest, AGltfAndItsBinaryChangeTogether) {
  const auto with_bytes = [&](const std::string& bytes) {
    return *read(asset(R"("buffers":[{"byteLength":4,"uri":"data:,)" + bytes +
                       R"("}],"bufferViews":[{"buffer":0,"byteLength":4}])"));
  };
  const fs::path path = folder_ /
                        "K\xC3\xA4"
                        "fer \xE6\xA8\xA1.gltf";
  ASSERT_TRUE(write_document(with_bytes("aaaa"), path).ok());
  ASSERT_EQ(files_ending(folder_, ".bin").size(), 1u);
  const fs::path first = files_ending(folder_, ".bin")[0];
  // As if writing had stopped before the .gltf was replaced: a folder has its name.
  fs::copy_file(path, folder_ / "copy.gltf");
  fs::remove(path);
  fs::create_directory(path);
  EXPECT_EQ(write_document(with_bytes("bbbb"), path).code(), StatusCode::kIo);
  const auto still = must(read_document(folder_ / "copy.gltf"));
  EXPECT_EQ(text_of(*buffer_view_bytes(still, 0)), "aaaa");
  // When it is replaced, its old bytes are removed. Files that are not ours and files that a copy shares stay.
  fs::remove(path);
  fs::copy_file(folder_ / "copy.gltf", path);
  write("other.bin", "cccc");
  ASSERT_TRUE(write_document(with_bytes("bbbb"), path).ok());
  EXPECT_EQ(text_of(*buffer_view_bytes(*read_document(path), 0)), "bbbb");
  EXPECT_TRUE(fs::exists(first));
  ASSERT_TRUE(write_document(with_bytes("aaaa"), path).ok());
  fs::remove(folder_ / "copy.gltf");
  ASSERT_TRUE(write_document(with_bytes("bbbb"), path).ok());
  EXPECT_FALSE(fs::exists(first));
  EXPECT_EQ(files_ending(folder_, ".bin").size(), 2u);
  ASSERT_TRUE(write_document(with_bytes("bbbb"), path).ok());
  EXPECT_EQ(files_ending(folder_, ".bin").size(), 2u);
}

TEST_F(DocumentTest, WhatALinkLeadsToIsWrittenWithItsBinaryBesideIt) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  const auto document = must(read(asset(R"("buffers":[{"byteLength":4,"uri":"data:,abcd"}],)"
                                        R"("bufferViews":[{"buffer":0,"byteLength":4}])")));
  fs::create_directories(folder_ / "there");
  ASSERT_TRUE(write_document(document, folder_ / "there" / "whole.gltf").ok());
  fs::create_symlink("there/whole.gltf", folder_ / "link.gltf");
  ASSERT_TRUE(write_document(document, folder_ / "link.gltf").ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.gltf"));
  EXPECT_TRUE(files_ending(folder_, ".bin").empty());
  const auto written = must(read_document(folder_ / "there" / "whole.gltf"));
  EXPECT_EQ(text_of(*buffer_view_bytes(written, 0)), "abcd");
}

TEST_F(DocumentTest, TheBinaryOfAnotherToolStays) {
  write("asset.bin", "dddd");
  const auto document = must(read(asset(R"("buffers":[{"byteLength":4,"uri":"asset.bin"}],)"
                                        R"("bufferViews":[{"buffer":0,"byteLength":4}])")));
  ASSERT_TRUE(write_document(document, folder_ / "asset.gltf").ok());
  EXPECT_TRUE(fs::exists(folder_ / "asset.bin"));
  EXPECT_EQ(text_of(*buffer_view_bytes(*read_document(folder_ / "asset.gltf"), 0)), "dddd");
}

TEST_F(DocumentTest, FallbackBuffersWithBytesBecomeOrdinary) {
  write("fallback.bin", "abcd");
  auto document = must(read(asset(R"("buffers":[{"uri":"fallback.bin","byteLength":4,)"
                                  R"("extensions":{"EXT_meshopt_compression":{"fallback":true}}}],)"
                                  R"("bufferViews":[{"buffer":0,"byteLength":4}])")));
  append_buffer_view(document, std::vector<uint8_t>{'e', 'f'});
  for (const char* name : {"out.glb", "out.gltf"}) {
    ASSERT_TRUE(write_document(document, folder_ / name).ok());
    const auto again = must(read_document(folder_ / name));
    EXPECT_EQ(text_of(*buffer_view_bytes(again, 0)), "abcd");
    EXPECT_EQ(text_of(*buffer_view_bytes(again, 1)), "ef");
  }
}

TEST(Glb, RefusesMoreThanFourGigabytes) {
  EXPECT_EQ(glb_head("{}", uint64_t{1} << 32).status().code(), StatusCode::kUnsupported);
  EXPECT_TRUE(glb_head("{}", (uint64_t{1} << 32) - 1024));
  EXPECT_TRUE(check_glb_bytes(UINT32_MAX).ok());
  const Status status = check_glb_bytes(uint64_t{1} << 32, true);
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_EQ(status.message(),
            "a GLB holds at most 4 GB, but this one takes at least 4294967296 bytes; write a .gltf");
}

// Two accessors in two views, an image in a third view, and a mesh with the second accessor.
Document three_views() {
  Document document = new_document();
  const AccessorData data{ComponentType::kUint8, 4, false, 2, Array<std::byte>(8, std::byte{7})};
  AccessorData other = data;
  other.values.assign(8, std::byte{9});
  append_accessor(document, data, 0, false);
  append_accessor(document, other, 0, false);
  const int64_t view = append_buffer_view(document, std::vector<uint8_t>{1, 2, 3});
  document.json()["images"] = Json::array({Json{{"bufferView", view}}});
  document.json()["meshes"][0]["primitives"][0]["attributes"]["_A"] = 1;
  return document;
}

TEST(DropUnused, RenumbersWhatStays) {
  Document document = three_views();
  const size_t before = document.buffers[0].size();
  drop_unused(document, {0});
  EXPECT_EQ(document.json()["accessors"].size(), 1u);
  EXPECT_EQ(document.json()["meshes"][0]["primitives"][0]["attributes"]["_A"], 0);
  EXPECT_EQ(document.json()["images"][0]["bufferView"], 1);
  EXPECT_EQ(read_accessor(document, 0)->values, Array<std::byte>(8, std::byte{9}));
  EXPECT_EQ((*buffer_view_bytes(document, 1))[2], 3);
  EXPECT_EQ(document.buffers[0].size(), before - 8);
}

TEST(DropUnused, KeepsAFreedAccessorThatIsStillUsed) {
  Document document = three_views();
  const Json before = document.json();
  drop_unused(document, {1});
  EXPECT_EQ(document.json(), before);
}

TEST(DropUnused, UnknownExtensionsFixNumbersAndKeepWhatTheyMayMean) {
  Document document = three_views();
  document.json()["extensions"]["NEVER_heard_of"]["thing"] = 1;
  drop_unused(document, {0});
  EXPECT_EQ(document.json()["accessors"].size(), 2u);
  EXPECT_FALSE(document.json()["accessors"][0].contains("bufferView"));
  EXPECT_EQ(document.json()["images"][0]["bufferView"], 2);
  EXPECT_EQ(read_accessor(document, 1)->values, Array<std::byte>(8, std::byte{9}));
  EXPECT_EQ((*buffer_view_bytes(document, 2))[2], 3);

  Document suspicious = three_views();
  suspicious.json()["extensions"]["NEVER_heard_of"]["accessor"] = 0;
  drop_unused(suspicious, {0});
  EXPECT_EQ(read_accessor(suspicious, 0)->values, Array<std::byte>(8, std::byte{7}));
}

TEST(DropUnused, ExtrasFixTheNumbersUpToThoseThatTheyMayName) {
  Document document = three_views();
  document.json()["nodes"][0]["extras"] = {{"data", {{"bufferView", 1}}}, {"id", 0}};
  document.json()["meshes"][0]["primitives"][0]["attributes"].erase("_A");
  document.json()["images"][0]["bufferView"] = 2;
  drop_unused(document, {0, 1});
  EXPECT_FALSE(document.json().contains("accessors"));
  ASSERT_EQ(document.json()["bufferViews"].size(), 3u);
  EXPECT_EQ((*buffer_view_bytes(document, 1))[0], 9);
  EXPECT_EQ((*buffer_view_bytes(document, 2))[2], 3);
}

TEST(DropUnused, EmptyArraysDisappear) {
  Document document = three_views();
  document.json()["meshes"][0]["primitives"][0]["attributes"].erase("_A");
  document.json().erase("images");
  drop_unused(document, {0, 1, 1, -1, 99});
  for (const char* name : {"accessors", "bufferViews", "buffers"}) EXPECT_FALSE(document.json().contains(name));
  EXPECT_TRUE(document.buffers.empty());
}

}  // namespace
}  // namespace psplit
