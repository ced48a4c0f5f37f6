// The bytes of a stream that can be read only once, such as a pipe, in a temporary file.
#pragma once

#include <filesystem>

#include "gltf_ext/files/mapped_file.h"
#include "gltf_ext/files/operating_system.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

struct SpooledBytes {
  UnnamedFile file;
  MappedFile bytes;
};

// Reads the rest of the stream, unpacked if it is gzip. Errors: those of the stream and of the file.
Expected<SpooledBytes> spool_bytes(Scanner& scanner, const std::filesystem::path& folder);

}  // namespace psplit
