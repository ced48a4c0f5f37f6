// Reads a file of any supported format, recognized by its content.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "mesh_files/asset_format.h"
#include "mesh_files/byte_stream.h"
#include "mesh_files/draco_file.h"
#include "mesh_files/obj.h"
#include "mesh_files/origin.h"
#include "mesh_files/scanner.h"
#include "psplit/decode.h"
#include "system/mapped_file.h"
#include "system/operating_system.h"

namespace psplit {

// Opens the libraries of materials that lie beside an OBJ, and adds the opened ones to `files`. Both must
// outlive the result.
OpenLibrary libraries_beside(const std::filesystem::path& source, std::vector<std::filesystem::path>& files);

// Bump maps were heights once, and are normals today. Adds a warning for each that is grey.
void say_heights(const MeshFile& file, const std::filesystem::path& folder, std::vector<std::string>& warnings);

struct Asset {
  Document document;
  std::vector<std::string> warnings;  // sentences about data that was left out or changed
  bool is_mesh_file = false;  // PLY, OBJ, STL or OFF: translations of nodes are the origins of positions
};

// Reads glTF, GLB, Draco, PLY, OBJ, STL and OFF, each of them plain or packed by gzip; "-" is stdin. The
// content decides the format. If it does not show one (an OBJ with unusual lines, broken files), the name
// decides. `describe` describes a Draco stream (mesh_files/draco_file.h). Mesh files are read through
// a window, so the whole file is never in memory. Materials and textures of an OBJ file are searched beside it.
// `access` is for read_document, of glTF. `progress` counts the bytes of a file that is not mapped. Draco
// files of points are read if `decode_points` is not empty. `pool` reads the text of PLY files. `origin`: what
// is subtracted from the positions of mesh files. Errors: kIo, kInvalidInput, kUnsupported (another format,
// another point cloud).
Expected<Asset> read_asset(const std::filesystem::path& path, const DescribeStream& describe,
                           FileAccess access = FileAccess::kRead, const Progress& progress = {},
                           const DecodePoints& decode_points = {}, const ThreadPool& pool = ThreadPool(1),
                           const OriginChoice& origin = {});

// Reads a file in memory, such as the content of a pipe (spool_bytes). The bytes of a GLB stay there.
Expected<Asset> read_asset(const MappedFile& file, const std::filesystem::path& source,
                           const DescribeStream& describe, const DecodePoints& decode_points = {},
                           const ThreadPool& pool = ThreadPool(1), const OriginChoice& origin = {});

// Reads a stream that was opened from `source`.
Expected<Asset> read_asset(std::unique_ptr<ByteStream> stream, const std::filesystem::path& source,
                           const DescribeStream& describe, const OriginChoice& origin = {});

// The bytes of a stream that can be read only once, such as a pipe, in a temporary file.
struct SpooledBytes {
  UnnamedFile file;
  MappedFile bytes;
};

// Reads the rest of the stream, unpacked if it is gzip. Errors: as for the stream and the file.
Expected<SpooledBytes> spool_bytes(Scanner& scanner, const std::filesystem::path& folder);

}  // namespace psplit
