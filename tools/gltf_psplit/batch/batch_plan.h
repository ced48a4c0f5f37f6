// Which files `batch` reads and where each output goes, decided before any work is done.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/status.h"
#include "tools/gltf_psplit/batch/batch_item.h"

namespace psplit {

struct BatchRequest {
  std::vector<std::string> words;  // files, folders, patterns, @lists of these
  std::filesystem::path folder;    // for the outputs
  std::string base;                // paths below `folder` are relative to it; empty: the deepest common folder
  std::string extension;           // of the outputs: ".glb" or ".gltf"
};

// A word is a file, a folder, a pattern, or "@list": a file with one of these on each line, or a comment after
// #. A pattern may contain *, ?, [] and, for any number of folders, **. It matches only files whose names
// `encode` reads, also links whose target is missing, and nothing in the output folder. A folder means
// FOLDER/**/*. The common folder contains all files, and the part of each pattern before its first wildcard. A
// file that is named twice is read once. Errors: kUsage for a pattern or a folder without an asset, an input
// outside `base`, two inputs with the same output, or an output that is an input; kIo for a list that cannot be
// read. A missing file is not an error here. The largest files come first, so that none of them begins at the
// end, when the other threads have nothing left to do.
// Whether a word has wildcards. A file may have such a name, too.
bool is_pattern(std::string_view text);

Expected<std::vector<BatchItem>> plan_batch(const BatchRequest& request);

}  // namespace psplit
