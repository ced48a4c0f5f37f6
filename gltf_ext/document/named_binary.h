// The .bin files of a .gltf, named after their content: "name.0123456789abcdef.bin". Such a name never replaces
// what a .gltf that still stands refers to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gltf_ext/files/files.h"

namespace psplit {

// Hexadecimal digits of a hash of the bytes, as names by content have them.
std::string content_digits(FileParts parts);

std::filesystem::path binary_path(const std::filesystem::path& gltf, FileParts parts);

// The binaries of the .gltf that stands at `path`, which nothing needs once it is replaced: named as
// binary_path does, with just the content that the name says.
std::vector<std::filesystem::path> own_binaries(const std::filesystem::path& path);

// Whether a .gltf of the folder has the binary's digits in it, or cannot be read.
bool is_used(const std::filesystem::path& binary);

}  // namespace psplit
