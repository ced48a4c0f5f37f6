// Reading and writing whole files; "-" is stdin or stdout.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "src/status.h"

namespace psplit {

// ".glb" for both a.glb and b.GLB.
std::string lower_extension(const std::filesystem::path& path);

// The first `limit` bytes of a file, or all bytes if it is shorter.
Expected<std::vector<uint8_t>> read_file(const std::filesystem::path& path, uint64_t limit = UINT64_MAX);

// Writes the parts one after the other to a temporary file beside `path` and renames it, so that the file
// appears whole or not at all. Pipes and devices are written directly.
using FileParts = std::span<const std::span<const uint8_t>>;
Status write_file(const std::filesystem::path& path, FileParts parts);
Status write_file(const std::filesystem::path& path, std::initializer_list<std::span<const uint8_t>> parts);

// The same with the bytes that `write` writes. It returns false after an error, with its errno.
Status write_file(const std::filesystem::path& path, const std::function<bool(std::FILE*)>& write);

// The same for a new file. Returns false and writes nothing if the name is taken.
Expected<bool> write_new_file(const std::filesystem::path& path, std::span<const uint8_t> bytes);

}  // namespace psplit
