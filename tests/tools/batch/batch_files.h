// Assets, outputs and reports of `gltf-psplit batch`, in a folder of the test.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "gltf_ext/json/json.h"
#include "tests/support/sanitizers.h"
#include "tests/tools/run_command.h"

namespace psplit {

// Sanitizers take memory and addresses of their own.
#ifdef PSPLIT_ASAN
inline constexpr bool kMeasuresMemory = false;
#else
inline constexpr bool kMeasuresMemory = true;
#endif

class BatchFiles : public CommandTest {
 protected:
  void generate(const std::string& name, const std::string& faces = "500", const std::string& seed = "1") {
    std::filesystem::create_directories((folder_ / name).parent_path());
    ASSERT_EQ(run({"generate", path(name), "--shape", "terrain", "--faces", faces, "--seed", seed, "-q"}), 0);
  }
  void generate_many(int count, const std::string& faces = "500") {
    for (int i = 0; i < count; ++i) generate("in/" + std::to_string(i) + ".glb", faces, std::to_string(i));
  }

  // The status of each asset in the lines of --progress json, by input.
  std::map<std::string, std::string> progress() const {
    std::map<std::string, std::string> statuses;
    std::istringstream lines(out_);
    for (std::string line; std::getline(lines, line);) {
      const Json row = Json::parse(line);
      EXPECT_TRUE(statuses.emplace(row["input"].get<std::string>(), row["status"].get<std::string>()).second);
    }
    return statuses;
  }
  static size_t count(const std::map<std::string, std::string>& statuses, const std::string& status) {
    size_t found = 0;
    for (const auto& [input, its] : statuses) found += its == status ? 1 : 0;
    return found;
  }

  // All files below a folder, with their bytes, except the batch's own.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path(name)))
      if (entry.is_regular_file() && entry.path().string().find(".gltf-psplit-batch") == std::string::npos)
        found[std::filesystem::relative(entry.path(), path(name)).string()] = read_bytes(entry.path());
    return found;
  }
  // No temporary file and no staged file remains.
  void expect_clean(const std::string& name) const {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path(name))) {
      const std::string file = entry.path().filename().string();
      EXPECT_FALSE(file.ends_with(".part") || contains(file, "-staged-")) << entry.path();
    }
  }
};

}  // namespace psplit
