// gltf-psplit decode to mesh files: they hold the content of the asset, and messages name what they cannot
// hold.
#include "gltf_ext/primitive/read_primitives.h"
#include "mesh_files/read_asset.h"
#include "psplit/decode.h"
#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

const std::string kImage = "\x89PNG\r\n\x1a\n an image";

class DecodeToMeshFile : public CommandOnSamples {
 protected:
  // The positions at the corners of all faces of all primitives, in their order.
  std::vector<float> corners_of(const std::string& name) const {
    std::vector<float> corners;
    const Asset asset = must(read_asset(path(name), describe_stream));
    for (const PrimitiveId id : all_primitives(asset.document)) {
      const Mesh mesh = must(read_primitive(asset.document, id, cpu_backend(), ThreadPool(1)));
      std::vector<float> positions(3 * mesh.point_count);
      std::memcpy(positions.data(), mesh.find("POSITION")->values.data(), positions.size() * sizeof(float));
      for (const auto& face : mesh.faces)
        for (const uint32_t point : face)
          corners.insert(corners.end(), positions.begin() + 3 * point, positions.begin() + 3 * point + 3);
    }
    return corners;
  }

  // two.gltf: a red mesh that two nodes show, one of them mirrored, and a mesh with a texture inside the asset.
  std::string scene_sample() const {
    const std::string png = "iVBORw0KGgogYW4gaW1hZ2U=";  // kImage in base64
    write("two.gltf",
          R"({"asset":{"version":"2.0"},"scene":0,"extensionsUsed":["KHR_texture_transform"],
      "scenes":[{"nodes":[0,1,2]}],
      "nodes":[{"mesh":0},{"mesh":0,"scale":[-1,2,1],"translation":[0,0,5]},{"mesh":1}],
      "meshes":[{"name":"flag","primitives":[{"attributes":{"POSITION":0},"indices":2,"material":0}]},
                {"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":1}]}],
      "materials":[{"name":"red","pbrMetallicRoughness":{"baseColorFactor":[1,0,0,0.5],"metallicFactor":0},
                    "alphaMode":"BLEND"},
                   {"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{
                    "KHR_texture_transform":{"offset":[0.25,0.5],"scale":[2,4]}}}},"doubleSided":false}],
      "textures":[{"source":0}],"images":[{"uri":"data:image/png;base64,)" +
              png +
              R"("}],
      "buffers":[{"byteLength":68,"uri":"data:application/octet-stream;base64,)"
              // (0, 0, 0), (1, 0, 0), (0, 1, 0); (0, 0), (1, 0), (0, 1); 0, 1, 2
              "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAABAAIAAAA="
              R"("}],
      "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},
                     {"buffer":0,"byteOffset":60,"byteLength":6}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
                   {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},
                   {"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}]})");
    return path("two.gltf");
  }
};

TEST_F(DecodeToMeshFile, EveryFormatHoldsTheDecodedBits) {
  const std::string split = split_sample();
  must_run({"decode", split, path("plain.glb"), "-q"});
  const std::vector<float> plain = corners_of("plain.glb");
  for (const std::string name : {"a.obj", "a.ply", "a.stl", "b.OBJ"}) {
    must_run({"decode", split, path(name), "-q", "--report", path("report.json")});
    EXPECT_TRUE(corners_of(name) == plain) << name;
    EXPECT_EQ(read_json("report.json").at("files").at("output").at("bytes"),
              std::filesystem::file_size(path(name)));
    if (name == "a.stl") continue;  // it has normals of facets
    must_run({"diff", split, path(name), "--tolerance", "0"});
  }
  must_run({"decode", split, path("a.drc"), "--quantize-position", "16"});
  EXPECT_EQ(read_bytes(path("a.drc")).substr(0, 5), "DRACO");
  must_run({"diff", split, path("a.drc")});
  must_run({"decode", path("a.drc"), path("back.glb"), "--backend", has_draco() ? "draco" : "cpu", "-q"});
  // The stream is the one that a .gltf of stock Draco has.
  must_run({"decode", split, path("stock.gltf"), "--to", "draco", "--quantize-position", "16", "-q"});
  EXPECT_TRUE(contains(read_bytes(path(binary_of("stock.gltf"))), read_bytes(path("a.drc"))));
}

TEST_F(DecodeToMeshFile, FullDisksMayPass) {
  if (!is_posix()) GTEST_SKIP() << "no links";
  const std::string split = split_sample();
  for (const std::string name : {"full.obj", "full.ply", "full.stl", "full.drc"}) {
    std::filesystem::create_symlink("/dev/full", path(name));
    EXPECT_EQ(run({"decode", split, path(name)}), 75) << name << err_;
  }
}

TEST_F(DecodeToMeshFile, LargeMeshesTakeLittleMemory) {
  const std::string split = split_sample();
  must_run({"decode", split, path("plain.glb"), "-q"});
  must_run({"decode", split, path("a.ply"), "--memory", "1GB", "-q"});
  EXPECT_TRUE(corners_of("a.ply") == corners_of("plain.glb"));
  EXPECT_EQ(run({"decode", split, path("a.drc"), "--memory", "1GB"}), 1);
}

TEST_F(DecodeToMeshFile, NodesPlaceTheMeshes) {
  const std::string input = scene_sample();
  must_run({"decode", input, path("a.stl"), "--accept-loss"});
  EXPECT_TRUE(contains(err_, "nodes move 1 object: positions are those of the scene"));
  EXPECT_TRUE(contains(err_, "3 primitives become one mesh"));
  const std::vector<float> corners = corners_of("a.stl");
  const std::vector<float> flag = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  ASSERT_EQ(corners.size(), 27u);
  std::multiset<float> z;
  for (size_t i = 2; i < corners.size(); i += 3) z.insert(corners[i]);
  EXPECT_EQ(z.count(5), 3u);
  EXPECT_EQ(z.count(0), 6u);
  for (const char* name : {"a.ply", "a.obj"}) {
    must_run({"decode", input, path(name), "--accept-loss", "-q"});
    std::vector<float> all = corners_of(name);
    ASSERT_EQ(all.size(), 27u) << name;
    // The mirror image turns round, so that its normal stays.
    const std::vector<float> mirrored = {0, 0, 5, 0, 2, 5, -1, 0, 5};
    EXPECT_NE(std::search(all.begin(), all.end(), mirrored.begin(), mirrored.end()), all.end()) << name;
    EXPECT_NE(std::search(all.begin(), all.end(), flag.begin(), flag.end()), all.end()) << name;
  }
}

TEST_F(DecodeToMeshFile, ObjHasObjectsMaterialsAndImages) {
  ASSERT_EQ(run({"decode", scene_sample(), path("out/a b.obj")}), 2);  // no folder
  std::filesystem::create_directory(path("out"));
  write("out/a b.mtl", "not ours");
  must_run({"decode", path("two.gltf"), path("out/a b.obj"), "--report", path("report.json")});
  EXPECT_EQ(read_bytes(path("out/a b.mtl")), "not ours");
  EXPECT_EQ(read_bytes(path("out/a b_image0.png")), kImage);
  must_run({"decode", path("out/a b.obj"), path("back.gltf"), "-q"});
  const nlohmann::json json = read_json("back.gltf");
  ASSERT_EQ(json.at("meshes").size(), 3u);
  EXPECT_EQ(json["meshes"][0]["name"], "flag");
  EXPECT_EQ(json["meshes"][1]["name"], "flag_2");
  EXPECT_EQ(json["meshes"][2]["name"], "mesh_1");
  const nlohmann::json red = json["materials"][0], textured = json["materials"][1];
  EXPECT_EQ(red["name"], "red");
  EXPECT_EQ(red["pbrMetallicRoughness"]["baseColorFactor"], nlohmann::json({1, 0, 0, 0.5}));
  EXPECT_EQ(red["pbrMetallicRoughness"]["metallicFactor"], 0);
  EXPECT_EQ(red["alphaMode"], "BLEND");
  EXPECT_EQ(textured["pbrMetallicRoughness"]["baseColorTexture"],
            nlohmann::json::parse(R"({"index":0,"extensions":{
              "KHR_texture_transform":{"offset":[0.25,0.5],"scale":[2,4]}}})"));
  EXPECT_EQ(json["images"][0]["uri"], "a%20b_image0.png");
  // All files count.
  uint64_t bytes = 0;
  for (const auto& file : std::filesystem::directory_iterator(path("out"))) bytes += file.file_size();
  EXPECT_EQ(read_json("report.json").at("files").at("output").at("bytes"), bytes - 8);
  // A second run writes no other files.
  must_run({"decode", path("two.gltf"), path("out/a b.obj"), "-q"});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("out")), {}), 4);
}

TEST_F(DecodeToMeshFile, NothingIsDroppedUnlessItIsAccepted) {
  const std::string input = scene_sample();
  std::string text = read_bytes(input);
  text.replace(text.find("\"doubleSided\":false"), 19,
               "\"doubleSided\":true,\"occlusionTexture\":{\"index\":0}");
  text.replace(text.find("[\"KHR_"), 1, "[\"EXT_unknown\",");
  text.replace(text.find("\"scene\":0"), 9, "\"scene\":0,\"cameras\":[{}]");
  write("rich.gltf", text);
  const auto loses = [&](const char* name, const std::string& what) {
    fails(5, {"decode", path("rich.gltf"), path(name)},
          std::string(name) + ": a " + std::string(name).substr(1) +
              " cannot hold all of the asset: with --accept-loss it is written without " + what);
    EXPECT_FALSE(std::filesystem::exists(path(name)));
    must_run({"decode", path("rich.gltf"), path(name), "--accept-loss"});
    EXPECT_TRUE(contains(err_, "warning: " + path(name) + ": is written without " + what));
    EXPECT_TRUE(std::filesystem::exists(path(name)));
  };
  loses("a.stl", "TEXCOORD_0, materials, cameras, EXT_unknown\n");
  loses("a.ply", "TEXCOORD_0, materials, cameras, EXT_unknown\n");
  loses("a.obj", "materials' doubleSided, materials' occlusionTexture, cameras, EXT_unknown\n");
  fails(5, {"decode", input, path("a.drc"), "--accept-loss"},
        "a .drc holds one primitive, but the scene shows 3");
  EXPECT_EQ(run({"decode", input, path("b.obj"), "--images", "embed"}), 1);
  EXPECT_EQ(run({"decode", input, path("b.obj"), "--to", "draco"}), 1);
  fails(1, {"decode", input, path("b.off")}, "the output must end in .glb, .obj, .ply, .stl, .drc or .gltf");
  EXPECT_EQ(run({"encode", input, path("b.obj")}), 1);
}

TEST_F(DecodeToMeshFile, DracoFilesHoldIntegersAsFloats) {
  write("integers.gltf",
        R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_mesh_quantization"],
    "extensionsRequired":["KHR_mesh_quantization"],"scene":0,"scenes":[{"nodes":[0]},{"nodes":[0]}],
    "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "buffers":[{"byteLength":24,"uri":"data:application/octet-stream;base64,AAAAAAAAAAABAAAAAAAAAAAAAQAAAAAA"}],
    "bufferViews":[{"buffer":0,"byteLength":24,"byteStride":8}],
    "accessors":[{"bufferView":0,"componentType":5123,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]})");
  fails(5, {"decode", path("integers.gltf"), path("a.drc"), "-q"}, "scenes beside the default one");
  must_run({"decode", path("integers.gltf"), path("a.drc"), "-q", "--accept-loss"});
  must_run({"decode", path("a.drc"), path("a.obj"), "-q"});
  EXPECT_EQ(corners_of("a.obj"), (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}));
}

}  // namespace
}  // namespace psplit
