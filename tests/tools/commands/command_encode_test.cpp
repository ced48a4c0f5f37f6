// gltf-psplit encode: options, the report, and primitives that are left as they are.
#include <algorithm>

#include "tests/tools/commands/sample_assets.h"

namespace psplit {
namespace {

class EncodeCommand : public CommandOnSamples {};

TEST_F(EncodeCommand, SaysInOneLineWhatItDid) {
  const std::string input = sample();
  const CommandOutcome loud = run_command({"encode", input, path("a.glb"), "--patches", "4"});
  EXPECT_EQ(loud.code, 0) << loud.err;
  EXPECT_EQ(loud.out, "");
  EXPECT_TRUE(contains(loud.err, "4 patches"));
  EXPECT_EQ(std::ranges::count(loud.err, '\n'), 1) << loud.err;
  must_run({"encode", input, path("b.glb"), "--patches", "4", "-q", "-j", "7"});
  EXPECT_EQ(err_, "");
  EXPECT_EQ(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
  EXPECT_GT(run_command({"encode", input, path("b.glb"), "-v"}).err.size(), loud.err.size());
}

TEST_F(EncodeCommand, CoarsePrimitivesAreForLoadersWithoutTheExtension) {
  const std::string input = path("mesh.glb"), coarse = path("coarse.glb");
  must_run({"generate", input, "--shape", "terrain", "--faces", "6000", "-q"});
  must_run({"encode", input, path("none.glb"), "--patches", "4", "-q"});
  const int code = run({"encode", input, coarse, "--patches", "4", "--fallback", "coarse=5%", "--report", "-"});
  if (lacks_library()) GTEST_SKIP() << err_;
  ASSERT_EQ(code, 0) << err_;
  const nlohmann::json report = nlohmann::json::parse(out_);
  const auto faces = report.at("coarse").at("faces").get<int>();
  EXPECT_GT(faces, 200);
  EXPECT_LT(faces, 700);
  EXPECT_GT(report.at("coarse").at("bytes"), 6 * faces);
  EXPECT_TRUE(contains(err_, "coarse faces in"));
  must_run({"validate", coarse});
  EXPECT_EQ(json_of({"inspect", coarse, "--format", "json"}).at("coarse").at("faces"), faces);
  EXPECT_TRUE(json_of({"inspect", path("none.glb"), "--format", "json"}).at("coarse").is_null());
  must_run({"inspect", coarse});
  EXPECT_TRUE(contains(out_, "coarse faces"));
  // Decoded, it is what it is without the option.
  must_run({"decode", path("none.glb"), path("a.glb"), "-q"});
  must_run({"decode", coarse, path("b.glb")});
  EXPECT_TRUE(contains(err_, "dropped"));
  must_run({"diff", path("a.glb"), path("b.glb")});
  for (const std::string share : {"coarse=", "coarse=5", "coarse=0%", "coarse=101%", "coarse=x%", "coarser"})
    fails(1, {"encode", input, coarse, "--fallback", share}, "is not none, uncompressed, coarse or");
  fails(1, {"encode", input, coarse, "--fallback", "coarse", "--compat", "khr"}, "--compat khr writes none");
  // A batch takes the option, too.
  must_run({"batch", input, "-o", path("out"), "--patches", "4", "--fallback", "coarse=5%", "-q"});
  EXPECT_EQ(read_bytes(path("out/mesh.glb")), read_bytes(coarse));
}

TEST_F(EncodeCommand, TakesFoldersAsBatchDoes) {
  write("in/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write("in/x/b.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  must_run({"encode", path("in"), "-o", path("out"), "--dry-run"});
  EXPECT_TRUE(contains(err_, path("out/a.glb") + " would be written\n"));
  EXPECT_TRUE(contains(err_, path("out/x/b.glb") + " would be written\n"));
  EXPECT_EQ(file_count(), 1u);
  must_run({"encode", path("in"), path("out")});
  EXPECT_EQ(out_, "");
  EXPECT_TRUE(contains(err_, "2 encoded, 0 up to date"));
  write("in/a.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n");
  must_run({"encode", path("in"), "-o", path("out"), "--dry-run"});
  EXPECT_TRUE(contains(err_, path("out/a.glb") + " would be replaced\n"));
  EXPECT_TRUE(contains(err_, path("out/x/b.glb") + " is up to date, and would be left\n"));
  // Several files, one file into a folder that exists, and another form.
  EXPECT_EQ(json_of({"encode", path("in/a.obj"), path("in/x/b.ply"), "-o", path("out"), "--report", "-"})
                .at("encoded"),
            1);
  must_run({"encode", path("in/a.obj"), "-o", path("out"), "--as", "gltf"});
  EXPECT_TRUE(std::filesystem::exists(path("out/a.gltf")));
  write("out/c.glb", "theirs");
  write("in/c.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(run({"encode", path("in"), "-o", path("out")}), 1);
  EXPECT_EQ(read_bytes(path("out/c.glb")), "theirs");

  for (const auto& [words, reason] : std::vector<std::pair<std::vector<std::string>, const char*>>{
           {{path("in/a.obj"), path("in/c.obj"), path("in/x/b.ply")}, "-o DIR"},
           {{path("in/a.obj"), path("in/c.obj"), "-o", "-"}, "-o DIR"},
           {{"-", path("in/a.obj"), "-o", path("out")}, "stdin"},
           {{path("in"), "-o", path("out"), "--memory", "200MB"}, "--memory takes one"},
           {{path("in/a.obj"), path("a.glb"), "--as", "gltf"}, "--as"}}) {
    std::vector<std::string> line = {"encode"};
    line.insert(line.end(), words.begin(), words.end());
    fails(1, line, reason);
  }
}

TEST_F(EncodeCommand, TakesPatternsAndListsIntoANewFolder) {
  write("in/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write("list", path("in/a.obj"));
  must_run({"encode", path("in/*.obj"), "-o", path("one")});
  must_run({"encode", "@" + path("list"), "-o", path("two")});
  EXPECT_TRUE(std::filesystem::exists(path("one/a.glb")) && std::filesystem::exists(path("two/a.glb")));
  // A report replaces no list, and no file of an asset.
  const std::string before = read_bytes(path("list"));
  EXPECT_EQ(run({"encode", "@" + path("list"), "-o", path("two"), "--report", path("list")}), 1);
  EXPECT_EQ(read_bytes(path("list")), before);
  // An empty name, as a script's empty variable gives it, makes no input the output.
  write("b.glb", "theirs");
  EXPECT_EQ(run({"encode", path("in/a.obj"), path("b.glb"), "-o", ""}), 1);
  EXPECT_EQ(read_bytes(path("b.glb")), "theirs");
}

TEST_F(EncodeCommand, AnAssetWithoutViewsGetsNone) {
  write("a.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":1,"uri":"data:,a"}]})");
  must_run({"encode", path("a.gltf"), path("b.gltf"), "-q"});
  EXPECT_FALSE(read_json("b.gltf").contains("bufferViews"));
}

TEST_F(EncodeCommand, AFolderAsInputNeedsOneForTheOutputs) {
  std::filesystem::create_directory(path("in"));
  fails(2, {"encode", path("in"), path("out.glb")},
        "in: may be several assets: they need a folder for the outputs, -o DIR");
}

TEST_F(EncodeCommand, DryRunsWriteNothing) {
  write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--memory", "200MB"}}) {
    const auto dry = [&](const std::string& input, const std::string& output) {
      std::vector<std::string> words = {"encode", path(input), path(output), "--dry-run"};
      words.insert(words.end(), more.begin(), more.end());
      return run(words);
    };
    EXPECT_EQ(dry("a.obj", "b.glb"), 0) << err_;
    EXPECT_TRUE(contains(err_, "b.glb would be written\n"));
    EXPECT_EQ(file_count(), 1u);
    write("b.glb", "earlier");
    EXPECT_EQ(dry("a.obj", "b.glb"), 0) << err_;
    EXPECT_TRUE(contains(err_, "b.glb would be replaced\n"));
    EXPECT_EQ(read_bytes(path("b.glb")), "earlier");
    std::filesystem::remove(path("b.glb"));
    EXPECT_EQ(dry("none.obj", "b.glb"), 2);
    EXPECT_EQ(dry("a.obj", "none/b.glb"), 2);
    EXPECT_EQ(dry("a.obj", "b.txt"), 1);
  }
}

TEST_F(EncodeCommand, ReportsAsJson) {
  must_run({"encode", sample("scene", "6000"), path("out.glb"), "--patch-faces", "500", "--report",
            path("report.json")});
  const auto report = read_json("report.json");
  EXPECT_TRUE(report.at("verified").get<bool>());
  EXPECT_EQ(report.at("primitives").size(), 6u);
  uint64_t patches = 0, bytes = 0;
  for (const auto& primitive : report.at("primitives")) {
    patches += primitive.at("patches").get<uint64_t>();
    bytes += primitive.at("bytes").at("total").get<uint64_t>();
    EXPECT_EQ(primitive.at("input").at("faces"), primitive.at("faces"));
  }
  EXPECT_EQ(report.at("total").at("patches"), patches);
  EXPECT_EQ(report.at("total").at("bytes").at("total"), bytes);
  for (const char* key : {"replication", "balance", "partition_ms", "encode_ms", "verify_ms", "wall_ms"})
    EXPECT_TRUE(report.at("total").at(key).is_number()) << key;
}

TEST_F(EncodeCommand, ChoosesTheBitsOfPositions) {
  const auto encode = [&](std::vector<std::string> options) {
    options.insert(options.begin(),
                   {"encode", sample("scene", "6000"), path("out.glb"), "--report", "-", "-q"});
    return json_of(options);
  };
  const auto bits = [](const nlohmann::json& report) {
    std::vector<int> counts;
    for (const auto& primitive : report.at("primitives")) {
      const auto& grid = primitive.at("position_grid");
      counts.push_back(grid.at("bits").get<int>());
      EXPECT_LE(primitive.at("position_error").get<double>(), grid.at("error_bound").get<double>());
    }
    return counts;
  };
  EXPECT_EQ(bits(encode({})), std::vector<int>(6, 14));
  const std::vector<int> edges = bits(encode({"--quantize-position", "auto"}));
  EXPECT_EQ(edges.size(), 6u);
  for (const int count : edges) EXPECT_TRUE(count >= 11 && count < 20) << count;
  // Objects on one grid share the bits that the finest of them needs.
  const std::vector<int> shared =
      bits(encode({"--quantize-position", "auto", "--quantization-volume", "scene"}));
  EXPECT_EQ(shared, std::vector<int>(6, shared.front()));
  EXPECT_GE(shared.front(), *std::max_element(edges.begin(), edges.end()));

  for (const char* volume : {"primitive", "mesh", "scene"}) {
    const auto report = encode({"--max-error", "0.5mm", "--quantization-volume", volume});
    EXPECT_LE(report.at("total").at("position_error").get<double>(), 0.0005);
    for (const auto& primitive : report.at("primitives")) {
      EXPECT_LE(primitive.at("position_grid").at("error_bound").get<double>(), 0.0005);
      EXPECT_GT(primitive.at("position_grid").at("error_bound").get<double>(), 0.0002);
    }
  }
  EXPECT_EQ(bits(encode({"--max-error", "50um"})), bits(encode({"--max-error", "0.005cm"})));
  EXPECT_EQ(bits(encode({"--max-error", "50um"})), bits(encode({"--max-error", "5e-5"})));
  fails(1, {"encode", sample(), path("b.glb"), "--max-error", "0.001um"}, "--lossless");
}

TEST_F(EncodeCommand, ProfilesChooseThePatchSizeAndExplicitOptionsWin) {
  const std::string input = sample("blob", "12000");
  const auto patches = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"encode", input, path("out.glb"), "--report", "-", "-q"});
    return nlohmann::json::parse(run_command(options).out).at("total").at("patches").get<int>();
  };
  EXPECT_EQ(patches({"--profile", "speed"}), 3);
  EXPECT_EQ(patches({"--profile", "speed", "--gpu", "h100"}), 27);  // patches have at least 440 faces
  EXPECT_EQ(patches({"--profile", "speed", "--gpu", "web"}), 24);   // 500 faces each
  EXPECT_EQ(patches({"--profile", "speed", "--gpu", "1", "--patch-faces", "6000"}), 2);
  EXPECT_EQ(patches({"--profile", "balanced"}), patches({}));
  EXPECT_EQ(patches({}), 1);
  EXPECT_EQ(patches({"--min-faces", "5000"}), 2);
  EXPECT_EQ(patches({"--profile", "speed", "--patches", "3"}), 3);
  EXPECT_EQ(patches({"--patches", "3", "--min-faces", "50000"}), 1);
  EXPECT_EQ(patches({"--profile", "size", "--patch-faces", "2000"}), 6);
}

TEST_F(EncodeCommand, DistanceTakesThePapersMethod) {
  const std::string input = sample("blob", "12000");
  const auto encoded = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"encode", input, path("out.glb"), "--patches", "10", "-q"});
    must_run(options);
    must_run({"validate", path("out.glb")});
    return read_bytes(path("out.glb"));
  };
  const std::string levels = encoded({}), dijkstra = encoded({"--distance", "dijkstra"});
  const std::string geodesic = encoded({"--distance", "geodesic"});
  EXPECT_NE(levels, dijkstra);
  EXPECT_NE(levels, geodesic);
  EXPECT_NE(dijkstra, geodesic);
  EXPECT_EQ(geodesic, encoded({"--distance", "geodesic", "-j", "3"}));
  EXPECT_NE(levels, encoded({"--no-refine"}));
}

TEST_F(EncodeCommand, BothEncodersWriteTheSameFile) {
  if (!has_draco()) GTEST_SKIP() << kNoDraco;
  for (const char* compat : {"none", "khr"}) {
    must_run({"encode", sample(), path("a.glb"), "--patches", "4", "--compat", compat});
    must_run({"encode", sample(), path("b.glb"), "--patches", "4", "--compat", compat, "--encoder", "draco"});
    EXPECT_EQ(read_bytes(path("a.glb")), read_bytes(path("b.glb")));
  }
  fails(1, {"encode", sample(), path("c.glb"), "--encoder", "other"}, "--encoder");
}

TEST_F(EncodeCommand, OrdersPatchesAndStoresTheirBoxes) {
  const auto encoded = [&](std::vector<std::string> more) {
    std::vector<std::string> options{"encode", sample(), path("out.glb"), "--patches", "12", "-q", "-f"};
    options.insert(options.end(), more.begin(), more.end());
    must_run(options);
    must_run({"validate", path("out.glb")});
    return read_bytes(path("out.glb"));
  };
  const std::string plain = encoded({});
  EXPECT_EQ(plain, encoded({"--order", "cut"}));
  const std::string by_size = encoded({"--order", "size"}), near = encoded({"--order", "near:1,-2.5,3e1"});
  EXPECT_NE(plain, by_size);
  EXPECT_NE(plain, near);
  EXPECT_NE(by_size, near);
  const size_t more = encoded({"--boxes"}).size() - plain.size();
  EXPECT_GE(more, 12u * 6);
  EXPECT_LE(more, 12u * 6 + 40);
  EXPECT_LT(encoded({"--boxes", "--condense"}).size(), plain.size());
  for (const char* wrong : {"near", "near:1,2", "near:1,2,3,4", "near:1,2,x", "near:1,2,inf", "far", ""})
    EXPECT_NE(run_command({"encode", sample(), path("no.glb"), "--order", wrong}).code, 0) << wrong;
  EXPECT_EQ(encoded({"--boxes"}), encoded({"--boxes", "--memory", "1GB"}));
}

TEST_F(EncodeCommand, CompatKhrWritesStockDracoPrimitives) {
  must_run({"encode", sample(), path("khr.glb"), "--patches", "4", "--compat", "khr", "--report",
            path("report.json"), "-q"});
  const auto total = read_json("report.json").at("total");
  EXPECT_EQ(total.at("patches"), 4);
  EXPECT_GT(total.at("replication"), 0.0);
  EXPECT_EQ(total.at("bytes").at("total"), total.at("bytes").at("payload"));
  const auto primitives = json_of({"inspect", path("khr.glb"), "--format", "json"}).at("primitives");
  ASSERT_EQ(primitives.size(), 4u);
  for (const auto& primitive : primitives) EXPECT_EQ(primitive.at("storage"), "draco");
  must_run({"decode", path("khr.glb"), path("plain.glb"), "-q"});
}

TEST_F(EncodeCommand, ReportsWhatItLeavesAndDrops) {
  write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\nf 1 1 2\n");
  const auto total = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words = {"encode", path("mesh.obj"), path("out.glb"), "--report", "-", "-q"};
    words.insert(words.end(), options.begin(), options.end());
    const auto report = json_of(words);
    EXPECT_EQ(report.at("input"), path("mesh.obj"));
    EXPECT_EQ(report.at("output"), path("out.glb"));
    EXPECT_EQ(report.at("primitives").at(0).at("mesh"), 0);
    return report;
  };
  const auto kept = total({"--always-patches", "--keep-degenerate"});
  EXPECT_EQ(kept.at("total").at("input"), nlohmann::json::parse(R"({"faces":3,"points":4,"bytes":66})"));
  EXPECT_EQ(kept.at("total").at("faces"), 3);
  EXPECT_EQ(kept.at("total").at("residue_faces"), 1);
  EXPECT_EQ(kept.at("total").at("dropped_faces"), 0);
  const auto dropped = total({"--always-patches", "--no-verify", "-j", "2"});
  EXPECT_EQ(dropped.at("total").at("faces"), 2);
  EXPECT_EQ(dropped.at("total").at("dropped_faces"), 1);
  EXPECT_FALSE(dropped.at("verified").get<bool>());
  EXPECT_EQ(dropped.at("threads"), 2);

  must_run({"encode", path("out.glb"), path("again.glb"), "--report", path("report.json")});
  EXPECT_TRUE(contains(err_, "mesh 0, primitive 0 is left as it is: already in patches"));
  EXPECT_TRUE(contains(err_, "warning: nothing to encode"));
  const auto report = read_json("report.json");
  EXPECT_EQ(report.at("primitives").at(0).at("skipped"), "already in patches");
}

// Patches are not encoded again, so options that ask for other patches must not end as a copy of the file.
TEST_F(EncodeCommand, RefusesOptionsThatPatchesOfTheInputCannotFollow) {
  const std::string split = split_sample();
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--patches", "3"}, {"--quantize-position", "8"}, {"--profile", "speed"}}) {
    std::vector<std::string> words = {"encode", split, path("again.glb")};
    words.insert(words.end(), options.begin(), options.end());
    fails(5, words,
          "split.glb: mesh 0, primitive 0: already in patches, which " + options[0] +
              " cannot change: decode the asset first");
    EXPECT_FALSE(std::filesystem::exists(path("again.glb")));
  }
  must_run({"encode", split, path("again.glb"), "--keep-unused", "--fallback", "none", "-q"});
}

TEST_F(EncodeCommand, DropsTheExtensionsThatTheUserNames) {
  must_run({"generate", path("a.gltf"), "--faces", "2000", "-q"});
  auto asset = read_json("a.gltf");
  asset["meshes"][0]["primitives"][0]["extensions"]["FB_ngon_encoding"] = nlohmann::json::object();
  asset["extensionsUsed"] = {"FB_ngon_encoding"};
  write("a.gltf", asset.dump());
  const CommandOutcome kept = run_command({"encode", path("a.gltf"), path("b.glb")});
  EXPECT_TRUE(contains(kept.err, "--drop-extension FB_ngon_encoding"));
  EXPECT_TRUE(contains(read_bytes(path("b.glb")), "FB_ngon_encoding"));
  must_run({"encode", path("a.gltf"), path("c.glb"), "--drop-extension", "FB_ngon_encoding", "--drop-extension",
            "NONE", "--report", path("r.json")});
  EXPECT_TRUE(contains(err_, "a.gltf: FB_ngon_encoding is dropped from 1 object"));
  EXPECT_TRUE(contains(err_, "a.gltf: NONE is not used"));
  EXPECT_EQ(read_json("r.json").at("dropped_extensions"), nlohmann::json({{"FB_ngon_encoding", 1}}));
  EXPECT_FALSE(contains(read_bytes(path("c.glb")), "FB_ngon_encoding"));
  EXPECT_LT(std::filesystem::file_size(path("c.glb")), std::filesystem::file_size(path("b.glb")) / 2);
  fails(1, {"encode", path("a.gltf"), path("d.glb"), "--drop-extension", "KHR_draco_mesh_compression"},
        "holds the meshes themselves");
}

TEST_F(EncodeCommand, CompressesPointsByMeshoptimizer) {
  must_run({"generate", path("a.gltf"), "--faces", "2000", "-q"});
  auto asset = read_json("a.gltf");
  asset["meshes"][0]["primitives"][0]["mode"] = 0;
  write("a.gltf", asset.dump());
  must_run({"encode", path("a.gltf"), path("plain.glb")});
  uintmax_t bytes = std::filesystem::file_size(path("plain.glb"));
  for (const std::string choice : {"--meshopt", "--meshopt=ext", "--meshopt=khr"}) {
    const int code = run({"encode", choice, path("a.gltf"), path("b.glb"), "--report", path("r.json")});
    if (lacks_library()) GTEST_SKIP() << err_;
    ASSERT_EQ(code, 0) << err_;
    EXPECT_TRUE(contains(err_, "nothing was encoded; "));
    EXPECT_TRUE(contains(err_, " of other data in "));
    EXPECT_FALSE(contains(err_, "nothing to encode"));
    EXPECT_GT(read_json("r.json").at("meshopt").at("views"), 0);
    EXPECT_EQ(contains(read_bytes(path("b.glb")), "KHR_meshopt_compression"), choice == "--meshopt=khr");
    EXPECT_EQ(contains(read_bytes(path("b.glb")), "EXT_meshopt_compression"), choice != "--meshopt=khr");
    EXPECT_LT(std::filesystem::file_size(path("b.glb")), bytes);
    must_run({"decode", path("b.glb"), path("c.glb"), "-q"});
    EXPECT_FALSE(contains(read_bytes(path("c.glb")), "meshopt"));
  }
  fails(1, {"encode", path("a.gltf"), path("d.glb"), "--meshopt=zip"}, "--meshopt");
  fails(1, {"encode", path("a.gltf"), path("d.glb"), "--meshopt", "--memory", "1GB"},
        "cannot be used with --memory");
  fails(1, {"encode", path("a.gltf"), path("d.glb"), "--animation-rotation-bits", "12"}, "requires --meshopt");
  fails(1, {"encode", path("a.gltf"), path("d.glb"), "--meshopt", "--lossless", "--animation-scale-bits", "9"},
        "excludes");
}

TEST_F(EncodeCommand, FallbackAndVolumeReachTheFile) {
  const std::string input = sample("scene", "3000");
  ASSERT_EQ(run_command({"encode", input, path("out.gltf"), "--fallback", "uncompressed",
                         "--quantization-volume", "scene"})
                .code,
            0);
  const auto json = read_json("out.gltf");
  EXPECT_FALSE(json.contains("extensionsRequired"));
  for (const auto& accessor : json.at("accessors")) EXPECT_TRUE(accessor.contains("bufferView"));
  must_run({"validate", path("out.gltf")});
}

}  // namespace
}  // namespace psplit
