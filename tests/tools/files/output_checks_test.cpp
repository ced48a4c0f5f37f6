// Outputs and reports are never an asset's own files, whatever the path says.
#include "tools/gltf_psplit/files/output_checks.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/test_folder.h"

namespace psplit {
namespace {

TEST(OutputChecks, AFileIsTheSameByEachOfItsPaths) {
  const TestFolder folder;
  const std::string inputs[] = {(folder / "in.glb").string()};
  std::ofstream(inputs[0]) << "x";
  std::ofstream(folder / "other.glb") << "x";
  const auto refuses = [&](const char* path) {
    return !check_not_an_input((folder / path).string(), "--report", inputs).ok();
  };
  EXPECT_TRUE(refuses("in.glb"));
  EXPECT_TRUE(refuses("./in.glb"));
  EXPECT_TRUE(refuses("new/../in.glb")) << "the folder may be made before the report is written";
  EXPECT_FALSE(refuses("other.glb"));
  EXPECT_FALSE(refuses("new.json"));
}

}  // namespace
}  // namespace psplit
