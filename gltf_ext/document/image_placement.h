// Where the images of an asset go when the asset is written to another folder.
#pragma once

namespace psplit {

// What to do with images that are files.
enum class ImagePlacement {
  kEmbed,      // buffer views
  kCopy,       // files in the output's folder
  kReference,  // the input's files, by URIs that lead to them from the output's folder
};

}  // namespace psplit
