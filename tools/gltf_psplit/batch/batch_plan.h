// What `batch` reads and where each result goes, settled before any work is done.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/status.h"

namespace psplit {

struct BatchItem {
  std::string input;
  std::filesystem::path output;  // below the output folder
  std::string name;              // the output relative to that folder
};

struct BatchRequest {
  std::vector<std::string> words;  // files, patterns, @lists of both
  std::filesystem::path folder;    // for the results
  std::string base;       // what paths below `folder` are relative to; empty: the deepest common folder
  std::string extension;  // of results: ".glb" or ".gltf"
};

// A word is a file, a pattern or "@list", a file with one of those a line. Patterns know *, ?, [] and, for any
// number of folders, **; they match only files that `encode` reads by name, and nothing in the output folder.
// The common folder is that of files and of what stands before the first wildcard of a pattern. Files named
// twice are read once. Errors: kUsage for patterns that match nothing, folders, inputs outside of `base`, two
// inputs with the same output and outputs that are inputs; kIo for lists that cannot be read. Files that are
// missing are no error here.
Expected<std::vector<BatchItem>> plan_batch(const BatchRequest& request);

}  // namespace psplit
