// The files that an asset names by URI and that are not loaded with it: images, and files that extensions name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"

namespace psplit {

enum class LinkState {
  kFound,     // a regular file
  kMissing,   // no file is there
  kAbsolute,  // an absolute path of one machine: not followed
  kWeb,       // http: or https:
  kUnknown,   // another scheme, or empty: its target is unknown
};

struct LinkedFile {
  std::string place;   // "image 3", or its place in the JSON: "extensions.X.clips[0]"
  int64_t image = -1;  // the index of the image, or -1
  std::string uri;     // as the JSON states it
  LinkState state;
  std::filesystem::path path;  // for kFound and kMissing: the asset's folder and the relative path
  std::filesystem::path relative;
  bool leaves_folder = false;  // for the same: the file is not below the asset's folder
};

// In the order of the JSON, without data URIs and without images that have a buffer view. Relative URIs start
// from the folder of document.source, or from the working directory if the asset was read from stdin.
std::vector<LinkedFile> linked_files(const Document& document);

// A sentence about a link that dangles: "image 3 names a file that is missing: \"x.png\"". Otherwise empty.
std::string describe_dangling(const LinkedFile& link);

}  // namespace psplit
