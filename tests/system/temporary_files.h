// A folder for tests of temporary files, and bytes to write.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <vector>

#include "tests/support/test_folder.h"

namespace psplit {

class TemporaryFilesTest : public testing::Test {
 protected:
  std::ptrdiff_t file_count() const { return std::distance(std::filesystem::directory_iterator(folder_), {}); }
  TestFolder folder_;
  const std::vector<uint8_t> bytes_ = std::vector<uint8_t>(100000, 7);
};

}  // namespace psplit
