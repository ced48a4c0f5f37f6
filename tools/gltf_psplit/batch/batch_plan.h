// Which files `batch` reads and where each output goes, decided before any work is done.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "tools/gltf_psplit/batch/manifest.h"

namespace psplit {

struct BatchRequest {
  std::vector<std::string> words;  // files, folders, patterns, @lists of these
  std::filesystem::path folder;    // for the outputs
  std::string base;                // paths below `folder` are relative to it; empty: the deepest common folder
  std::string extension;           // of the outputs: ".glb" or ".gltf"
};

// Whether `text` has wildcards. A file may have such a name, too.
bool is_pattern(std::string_view text);

// The files that the words mean, the largest first, so that none begins when the other threads have nothing
// left to do. A word is a file, a folder (FOLDER/**/*), a pattern, or "@list": a file with one of these on each
// line, or a comment after #. A pattern with *, ?, [] and, for any number of folders, ** matches what `encode`
// reads, also links whose target is missing, but nothing in the output folder. The common folder contains all
// files, and the part of each pattern before its first wildcard. A file named twice is read once; a missing one
// is no error here. Errors: kUsage for a pattern or a folder without an asset, an input outside `base`, two
// inputs with the same output, or an output that is an input; kIo for a list that cannot be read.
Expected<std::vector<BatchItem>> plan_batch(const BatchRequest& request);

}  // namespace psplit
