// The size of an asset on disk: its file, and the buffers and images beside it. Textures are counted apart,
// because psplit does not compress them.
#pragma once

#include <cstdint>
#include <string>

#include "gltf_ext/document/document.h"

namespace psplit {

struct AssetBytes {
  uint64_t files = 0;     // all files together; 0 if unknown, as for stdout
  uint64_t textures = 0;  // the images among these bytes, embedded or beside the file

  AssetBytes& operator+=(const AssetBytes& other) {
    files += other.files;
    textures += other.textures;
    return *this;
  }
};

// For a glTF or mesh file. 0 for "-", a pipe, or a path that is not a file.
AssetBytes bytes_on_disk(const std::string& path);
// As above, for a caller that has the result of read_asset_json.
AssetBytes bytes_on_disk(const std::string& path, const Expected<Json>& json);

// For an asset that was read: all files that it was read from, such as the MTL files of an OBJ, and its images.
// 0 if it came from a pipe.
AssetBytes bytes_on_disk(const Document& document);

// The JSON of an asset. Of a GLB, only the header and the JSON chunk are read; of a file that begins neither
// like a GLB nor like JSON, only the first bytes. Errors: as for read_file and parse_json.
Expected<Json> read_asset_json(const std::string& path);

// The sizes of an input and of its output.
struct AssetSizes {
  AssetBytes input, output;

  AssetSizes& operator+=(const AssetSizes& other) {
    input += other.input;
    output += other.output;
    return *this;
  }
};

// "1.18 MB from 34.1 MB (3.4 %)", and ", of which textures 0.5 MB" or "... 0.5 MB from 0.6 MB"; empty if the
// output's size is unknown.
std::string sizes_text(const AssetSizes& sizes);

// The last line of a command that writes an asset: "out.glb: 1.18 MB from 34.1 MB (3.4 %); 1 primitive
// decoded". `done` says what the command did. Unknown sizes are left out.
std::string written_text(const std::string& output, const AssetSizes& sizes, const std::string& done);

// {"input": {"bytes", "texture_bytes"}, "output": the same, "ratio": output / input}; null for an unknown size.
Json sizes_json(const AssetSizes& sizes);

}  // namespace psplit
