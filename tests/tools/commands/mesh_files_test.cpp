// Mesh files through the command: by content, from stdin and from gzip, with every subcommand that reads
// assets.
#include <zlib.h>

#include <nlohmann/json.hpp>

#include "tests/tools/run_command.h"

namespace psplit {
namespace {

const std::string kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n";
const std::string kOff = "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n";
const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 "
    "2\n3 1 3 2\n";
const std::string kStl =
    "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

class MeshFiles : public CommandTest {
 protected:
  void write_gzip(const std::string& name, const std::string& text) const {
    const gzFile file = gzopen(path(name).c_str(), "wb");
    ASSERT_NE(file, nullptr);
    EXPECT_EQ(gzwrite(file, text.data(), static_cast<unsigned>(text.size())), static_cast<int>(text.size()));
    EXPECT_EQ(gzclose(file), Z_OK);
  }
};

TEST_F(MeshFiles, EveryFormatIsReadFromFilesPipesAndGzip) {
  for (const std::string& file : {kObj, kOff, kPly, kStl}) {
    write("plain.txt", file);
    write_gzip("packed.bin", file);
    for (const char* name : {"plain.txt", "packed.bin"}) {
      CommandOutcome outcome =
          run_command({"encode", path(name), path("out.glb"), "--always-patches", "--report", "-", "-q"});
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      EXPECT_EQ(nlohmann::json::parse(outcome.out).at("total").at("faces"), 2);
      must_run({"validate", path("out.glb"), "-q"});
      must_run({"diff", path(name), path("out.glb"), "-q"});
      outcome = run_command({"inspect", path(name)});
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      EXPECT_TRUE(contains(outcome.out, "mesh 0, primitive 0: plain"));
      outcome = run_command_on(path(name), {"encode", "-", path("piped.glb"), "-q"});
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      must_run({"diff", path("piped.glb"), path("out.glb"), "-q", "--tolerance", "0"});
    }
  }
}

TEST_F(MeshFiles, BatchTakesEveryName) {
  write("in/a.obj", kObj);
  write("in/b.off", kOff);
  write_gzip("in/c.ply.gz", kPly);
  write_gzip("in/d.STL.GZ", kStl);
  write("in/notes.gz", "no asset");
  must_run({"batch", path("in/*"), "--out-dir", path("out"), "--report", path("report.json"), "-q"});
  for (const char* name : {"out/a.glb", "out/b.glb", "out/c.glb", "out/d.glb"})
    EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
}

TEST_F(MeshFiles, WhatIsLostIsSaidByEveryCommand) {
  write("loss.obj", kObj + "f 1 2\n");
  const std::string said = "warning: " + path("loss.obj") + ": 1 face of fewer than 3 corners is left out";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"encode", path("loss.obj"), path("a.glb")},
        {"decode", path("loss.obj"), path("b.glb")},
        {"inspect", path("loss.obj")},
        {"diff", path("loss.obj"), path("a.glb")},
        {"batch", path("loss.obj"), "--out-dir", path("out"), "--report", path("report.json")}}) {
    must_run(words);
    EXPECT_TRUE(contains(err_, said)) << words[0] << ": " << err_;
  }
}

TEST_F(MeshFiles, BrokenFilesAreNamedOnceAndLeaveNothing) {
  write("cut.ply", kPly.substr(0, kPly.size() - 6));
  write("far.obj", kObj + "f 1 2 9\n");
  write("empty.stl", "");
  for (const auto& [name, message] :
       {std::pair{"cut.ply", "line 15: the file ends inside its element \"face\""},
        {"far.obj", "line 7: a face names vertex 9, but there are 4"},
        {"empty.stl", "the file is empty"}}) {
    EXPECT_EQ(run({"encode", path(name), path("out.glb")}), 3);
    EXPECT_EQ(err_, "gltf-psplit: error: " + path(name) + ": " + message + "\n");
    EXPECT_FALSE(std::filesystem::exists(path("out.glb")));
  }
}

}  // namespace
}  // namespace psplit
