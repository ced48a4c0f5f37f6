// `validate` and `inspect` process all files that they are given, and fail if one of them fails.
#include "tools/gltf_psplit/files/many_files.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/tools/run_command.h"
#include "tools/gltf_psplit/report/text_layout.h"

namespace psplit {
namespace {

class ManyFiles : public CommandTest {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_command({"generate", path("plain.glb"), "--faces", "2k", "-q"}).code, 0);
    ASSERT_EQ(run_command({"encode", path("plain.glb"), path("split.glb"), "--patches", "2", "-q"}).code, 0);
    std::ofstream(path("broken.gltf")) << "{";
  }
};

TEST_F(ManyFiles, ValidateSaysALineAFile) {
  must_run({"validate", path("plain.glb"), path("split.glb")});
  EXPECT_EQ(out_, path("plain.glb") + ": valid\n" + path("split.glb") + ": valid\n");
  EXPECT_EQ(err_, "");
}

TEST_F(ManyFiles, ValidateGoesOnAfterFailures) {
  EXPECT_EQ(run({"validate", path("broken.gltf"), path("none.glb"), path("split.glb")}),
            3);  // the code of the first failure
  EXPECT_TRUE(contains(out_, path("broken.gltf") + ": invalid, 1 error\n"));
  EXPECT_TRUE(contains(out_, path("split.glb") + ": valid\n"));
  EXPECT_TRUE(contains(err_, "none.glb"));
  EXPECT_TRUE(contains(err_, "2 of 3 files failed"));
  EXPECT_EQ(run({"validate", path("none.glb"), path("broken.gltf")}), 2);
}

TEST_F(ManyFiles, JsonIsAnArrayWhereThereAreSeveral) {
  const CommandOutcome one = run_command({"validate", path("split.glb"), "--format", "json"});
  const auto object = nlohmann::json::parse(one.out);
  ASSERT_TRUE(object.is_object());
  EXPECT_EQ(object.at("file"), path("split.glb"));
  EXPECT_EQ(object.at("valid"), true);

  for (const char* verb : {"validate", "inspect"}) {
    EXPECT_EQ(run({verb, path("split.glb"), path("none.glb"), path("plain.glb"), "--format", "json", "-q"}), 2);
    const auto array = nlohmann::json::parse(out_);
    ASSERT_EQ(array.size(), 3u) << out_;
    EXPECT_EQ(array.at(0).at("file"), path("split.glb"));
    EXPECT_EQ(array.at(1).at("error").at("code"), 2);
    EXPECT_TRUE(contains(array.at(1).at("error").at("message"), "none.glb"));
    EXPECT_EQ(array.at(2).at("file"), path("plain.glb"));
  }
}

TEST_F(ManyFiles, InspectHasARowAFile) {
  EXPECT_EQ(run({"inspect", path("split.glb"), path("broken.gltf"), path("plain.glb"), "-q"}), 3);
  std::istringstream lines(out_);
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(line);
  ASSERT_EQ(rows.size(), 3u) << out_;
  EXPECT_TRUE(rows[0].ends_with("  file")) << rows[0];
  EXPECT_TRUE(rows[1].ends_with("  " + path("split.glb"))) << rows[1];
  EXPECT_TRUE(rows[2].ends_with("  " + path("plain.glb"))) << rows[2];
  const auto width = [&](const std::string& row, const std::string& file) { return row.size() - file.size(); };
  EXPECT_LE(width(rows[1], path("split.glb")), 80u);
}

TEST_F(ManyFiles, SomeThingsAreForOneFile) {
  EXPECT_EQ(run({"validate", "-", "-"}), 1);
  EXPECT_EQ(run({"inspect", "-", path("split.glb"), "-"}), 1);
  fails(1, {"inspect", path("split.glb"), path("plain.glb"), "--preview", path("a.png")},
        "--preview draws one asset, and there are 2 files");
}

// Tables have at most 100 columns without --wide.
TEST_F(ManyFiles, TablesFit) {
  for (std::vector<std::string> words : {std::vector<std::string>{"inspect", path("split.glb")},
                                         {"compare", path("plain.glb"), "--repeat", "1", "--patches", "1,2"}}) {
    if (words.front() == "compare" && !has_draco()) continue;
    const std::string narrow = run_command(words).out;
    std::istringstream lines(narrow);
    std::string line;
    std::getline(lines, line);  // the first line has the name of the file
    while (std::getline(lines, line)) EXPECT_LE(line.size(), kTableWidth) << line;
    EXPECT_FALSE(contains(narrow, "balance"));
    words.push_back("--wide");
    const std::string wide = run_command(words).out;
    EXPECT_TRUE(contains(wide, "balance"));
  }
}

}  // namespace
}  // namespace psplit
