// The bytes of a document's images.
#pragma once

#include <cstdint>
#include <filesystem>

#include "gltf_ext/json/json.h"

namespace psplit {

// Each buffer view and each file counts once.
struct ImageBytes {
  uint64_t in_json = 0;     // data URIs, as text
  uint64_t in_buffers = 0;  // buffer views
  uint64_t in_files = 0;    // files beside the asset
  uint64_t missing = 0;     // number of images without a file; their bytes are unknown

  uint64_t total() const { return in_json + in_buffers + in_files; }
};

// `folder` is the asset's folder. Files are not read.
ImageBytes image_bytes(const Json& json, const std::filesystem::path& folder);

}  // namespace psplit
