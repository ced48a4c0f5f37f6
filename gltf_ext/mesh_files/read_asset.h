// Any file that psplit reads, told by its content.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/mesh_files/byte_stream.h"
#include "src/container/stream_description.h"

namespace psplit {

struct Asset {
  Document document;
  std::vector<std::string> warnings;  // what was left out of the file or changed, a sentence each
};

// Reads glTF, GLB, Draco, PLY, OBJ, STL and OFF, and each of them packed by gzip; "-" is stdin. Content tells
// which it is; only where it does not (an OBJ of unusual lines, broken files) does the name. `describe`
// describes a Draco stream (gltf_ext/convert/draco_file.h). Mesh files are read in a window: the file itself is
// not held in memory. Materials and textures of OBJ are looked for beside it. Errors: kIo, kInvalidInput,
// kUnsupported (another format, a point cloud).
Expected<Asset> read_asset(const std::filesystem::path& path, const DescribeStream& describe);

// The same of a stream that came from `source`.
Expected<Asset> read_asset(std::unique_ptr<ByteStream> stream, const std::filesystem::path& source,
                           const DescribeStream& describe);

// Whether a name is one of those formats': ".ply" and ".ply.gz" among others, in any case.
bool is_asset_name(const std::filesystem::path& path);
// The name without ".gz", and without what is before it where that names a format: "a.ply.gz" becomes "a".
std::filesystem::path without_asset_extensions(const std::filesystem::path& path);
// "A .gltf, .glb, ... file", for helps and messages: ".gltf, .glb, .drc, .ply, .obj, .stl or .off".
std::string asset_extensions_text();

}  // namespace psplit
