// What an asset takes on disk: its file, and the buffers and images that lie beside it; textures apart, which
// psplit never makes smaller.
#pragma once

#include <cstdint>
#include <string>

#include "gltf_ext/document/document.h"

namespace psplit {

struct AssetBytes {
  uint64_t files = 0;     // all of them together; 0 where that is not known, as of what went to stdout
  uint64_t textures = 0;  // of these, what images take, embedded or beside

  AssetBytes& operator+=(const AssetBytes& other) {
    files += other.files;
    textures += other.textures;
    return *this;
  }
};

// Of a glTF or mesh file; "-", pipes and what is no file come to 0.
AssetBytes bytes_on_disk(const std::string& path);

// What went in and what came out.
struct AssetSizes {
  AssetBytes input, output;

  AssetSizes& operator+=(const AssetSizes& other) {
    input += other.input;
    output += other.output;
    return *this;
  }
};

// "1.18 MB from 34.1 MB (3.4 %)", and ", of which textures 0.5 MB" or "... 0.5 MB from 0.6 MB"; empty where the
// output's size is not known.
std::string sizes_text(const AssetSizes& sizes);

// {"input": {"bytes", "texture_bytes"}, "output": the same, "ratio": output / input}; null for what is not
// known.
Json sizes_json(const AssetSizes& sizes);

}  // namespace psplit
