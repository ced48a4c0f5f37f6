// Mesh files whose positions are doubles or decimals, far from the origin: every command keeps and counts what
// floats alone would lose.
#include <set>

#include "tests/mesh_files/far_mesh.h"
#include "tests/tools/run_command.h"

namespace psplit {
namespace {

class Origins : public CommandTest {
 protected:
  void SetUp() override {
    write("a.ply", far_ply(true, 60));
    write("a.obj", far_obj(60));
    write("a.stl", far_stl(60));
  }

  // Places in the grid of far_points, of the vertices of an OBJ.
  std::set<std::pair<int, int>> cells_of(const std::string& obj) const {
    std::set<std::pair<int, int>> cells;
    std::istringstream lines(read_bytes(path(obj)));
    for (std::string line; std::getline(lines, line);) {
      double x = 0, y = 0;
      if (std::sscanf(line.c_str(), "v %lf %lf", &x, &y) != 2) continue;
      const double column = (x - kFarCorner[0]) / kFarStep, row = (y - kFarCorner[1]) / kFarStep;
      EXPECT_NEAR(column, std::round(column), 0.1);
      EXPECT_NEAR(row, std::round(row), 0.1);
      cells.insert({static_cast<int>(std::round(column)), static_cast<int>(std::round(row))});
    }
    return cells;
  }
};

TEST_F(Origins, EncodeCompareAndDecode) {
  for (const char* input : {"a.ply", "a.obj", "a.stl"})
    for (const std::vector<std::string>& options : {std::vector<std::string>{},
                                                    {"--lossless"},
                                                    {"--max-error", "1mm"},
                                                    {"--memory", "128MiB"},
                                                    {"--origin", "500000,5400000,0"},
                                                    {"--quantize-position", "auto"}}) {
      SCOPED_TRACE(std::string(input) + (options.empty() ? "" : " " + options[0]));
      std::vector<std::string> words{"encode", path(input), path("a.glb")};
      words.insert(words.end(), options.begin(), options.end());
      must_run(words);
      EXPECT_TRUE(contains(err_, "relative to the origin 500000,540000"));
      must_run({"diff", path(input), path("a.glb")});
      must_run({"diff", path("a.glb"), path(input)});
      must_run({"diff", path(input), path("a.glb"), "--scene"});
      must_run({"decode", path("a.glb"), path("back.obj"), "--accept-loss"});
      EXPECT_EQ(cells_of("back.obj").size(), 3600u);
      must_run({"decode", path("a.glb"), path("back.ply"), "--accept-loss"});
      EXPECT_TRUE(contains(read_bytes(path("back.ply")), "property double x"));
      must_run({"diff", path("back.ply"), path("back.obj"), "--attributes", "POSITION"});
    }
}

TEST_F(Origins, AnOriginThatIsMissingIsADifference) {
  must_run({"encode", path("a.ply"), path("lossy.glb"), "--origin", "none"});
  EXPECT_TRUE(contains(err_, "positions are off by up to 0.2"));
  EXPECT_EQ(run({"diff", path("a.ply"), path("lossy.glb")}), 7) << out_ << err_;
  EXPECT_EQ(run({"diff", path("lossy.glb"), path("a.ply")}), 7);
  EXPECT_EQ(run({"diff", path("lossy.glb"), path("a.ply"), "--scene"}), 7);
  // A node that is somewhere else.
  must_run({"encode", path("a.ply"), path("a.glb"), "--lossless"});
  must_run({"decode", path("a.glb"), path("a.gltf")});
  std::string json = read_bytes(path("a.gltf"));
  const size_t at = json.find("500000.0");
  ASSERT_NE(at, json.npos);
  json[at + 5] = '1';
  write("b.gltf", json);
  EXPECT_EQ(run({"diff", path("a.ply"), path("b.gltf")}), 7);
  must_run({"diff", path("a.ply"), path("a.gltf")});
}

// Floats are as coarse there as without an origin.
TEST_F(Origins, AnOriginThatIsNoHelp) {
  must_run({"encode", path("a.ply"), path("lossy.glb"), "--origin", "0.5,0,0"});
  EXPECT_TRUE(contains(err_, "positions are off by up to 0.2"));
  EXPECT_EQ(run({"diff", path("a.ply"), path("lossy.glb")}), 7) << out_ << err_;
  EXPECT_EQ(run({"diff", path("lossy.glb"), path("a.ply")}), 7) << out_ << err_;
  EXPECT_EQ(run({"diff", path("a.ply"), path("lossy.glb"), "--scene"}), 7) << out_ << err_;
}

// Of 500002.125, the shortest digits that give the float are 500002.12.
TEST_F(Origins, FloatsFarAwayHaveAllDigitsInATextOfDoubles) {
  must_run({"encode", path("a.ply"), path("coarse.glb"), "--origin", "none"});
  must_run({"decode", path("coarse.glb"), path("coarse.obj")});
  must_run({"diff", path("coarse.glb"), path("coarse.obj")});
  must_run({"encode", path("coarse.obj"), path("again.glb")});
  EXPECT_FALSE(contains(err_, "origin")) << err_;
}

TEST_F(Origins, PlainGltfAndFormatsOfFloats) {
  must_run({"decode", path("a.ply"), path("plain.glb")});
  must_run({"diff", path("a.ply"), path("plain.glb")});
  must_run({"encode", path("plain.glb"), path("again.glb")});
  must_run({"diff", path("a.ply"), path("again.glb")});
  fails(5, {"decode", path("plain.glb"), path("b.stl")}, "digits of positions that floats cannot hold");
  must_run({"decode", path("plain.glb"), path("b.stl"), "--accept-loss"});
  must_run({"decode", path("plain.glb"), path("c.glb"), "--origin", "none"});
  EXPECT_TRUE(contains(err_, "--origin is for PLY, OBJ, STL and OFF"));
}

TEST_F(Origins, OfABatch) {
  std::filesystem::create_directory(path("in"));
  std::filesystem::copy_file(path("a.ply"), path("in/a.ply"));
  must_run({"batch", path("in"), "--out-dir", path("out")});
  must_run({"diff", path("a.ply"), path("out/a.glb")});
  must_run({"batch", path("in"), "--out-dir", path("out"), "--origin", "500000,5400000,0"});
  must_run({"decode", path("out/a.glb"), path("a.gltf")});
  EXPECT_EQ(read_json("a.gltf")["nodes"][0]["translation"], (nlohmann::json{500000.0, 5400000.0, 0.0}));
  fails(1, {"encode", path("a.ply"), path("a.glb"), "--origin", "1,2"}, "neither none nor X,Y,Z");
}

}  // namespace
}  // namespace psplit
