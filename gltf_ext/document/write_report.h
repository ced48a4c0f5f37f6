// The result of writing a document.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace psplit {

struct WriteReport {
  std::vector<std::string> warnings;         // references that dangle in the output, and data that it loses
  std::vector<std::string> notes;            // files that got another name
  std::vector<std::filesystem::path> files;  // all files of the output, newly written or already there
  size_t embedded_images = 0, copied_images = 0;
  uint64_t image_bytes = 0;  // of embedded and copied images; every file counts once
};

}  // namespace psplit
