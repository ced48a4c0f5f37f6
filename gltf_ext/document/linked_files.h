// The files beside an asset that it names by URI and that are not loaded with it: images, and whatever
// extensions name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"

namespace psplit {

enum class LinkState {
  kFound,     // a regular file
  kMissing,   // no file is there
  kAbsolute,  // a path of one machine: not followed
  kWeb,       // http: or https:
  kUnknown,   // another scheme, or no name: where it leads is not known here
};

struct LinkedFile {
  std::string place;           // "image 3", or where it stands in the JSON: "extensions.X.clips[0]"
  int64_t image = -1;          // the number of the image, -1 for all else
  std::string uri;             // as the JSON has it
  LinkState state;             //
  std::filesystem::path path;  // of kFound and kMissing: the asset's folder and the relative path
  bool leaves_folder = false;  // of the same: the file is not below the asset's folder
};

// In the order of the JSON. Data URIs and images that have a buffer view are no links. Relative URIs start from
// the folder of document.source, those of an asset on stdin from the working directory.
std::vector<LinkedFile> linked_files(const Document& document);

// What is wrong with a link, in words: "image 3 is missing: \"x.png\"". Empty where nothing is.
std::string describe_dangling(const LinkedFile& link);

}  // namespace psplit
