// The .bin files of a .gltf, named after their content: "name.0123456789abcdef.bin". A new file with such a
// name never replaces other bytes that an existing .gltf refers to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "system/files.h"

namespace psplit {

// The hexadecimal digits of a hash of the bytes, for names after the content.
std::string content_digits(FileParts parts);

// "folder/name.0123456789abcdef.bin" for "folder/name.gltf", the digits and ".bin". A name that would be too
// long for a file is cut before the digits.
std::filesystem::path path_with_digits(const std::filesystem::path& path, const std::string& digits,
                                       const std::string& extension);

// Writes a new file in `folder` under the first of the names that is free, so that no other file is replaced.
// An existing file with the same bytes serves as well. Returns the name, or nothing if others have all names.
Expected<std::filesystem::path> write_beside(const std::filesystem::path& folder,
                                             std::span<const std::filesystem::path> names,
                                             std::span<const uint8_t> bytes);

std::filesystem::path binary_path(const std::filesystem::path& gltf, FileParts parts);

// The binaries of the existing .gltf at `path` that nothing needs once it is replaced: binary_path gives their
// names, which match their content.
std::vector<std::filesystem::path> own_binaries(const std::filesystem::path& path);

// Whether a .gltf in the binary's folder contains its digits, or cannot be read.
bool is_used(const std::filesystem::path& binary);

}  // namespace psplit
