// Reading and writing whole files; "-" is stdin or stdout.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "psplit/base.h"

namespace psplit {

// An open file, which is closed with its owner unless it is stdin or stdout.
struct CloseFile {
  void operator()(std::FILE* file) const {
    if (file != stdin && file != stdout) std::fclose(file);
  }
};
using OpenFile = std::unique_ptr<std::FILE, CloseFile>;

// ".glb" for both a.glb and b.GLB.
std::string lower_extension(const std::filesystem::path& path);

// The first `limit` bytes of a file, or all bytes if it is shorter.
Expected<std::vector<uint8_t>> read_file(const std::filesystem::path& path, uint64_t limit = UINT64_MAX);

// What happens to a file that this process may not write to, or that has no permission to write at all.
enum class IfReadOnly { kFail, kReplace };

// Writes the parts one after the other to a temporary file beside `path` and renames it, so that the file
// appears whole or not at all. A file that is replaced keeps its permissions and, if the system allows it, its
// owner. A link stays, and what it leads to is written, also if that does not exist yet. Pipes and devices are
// written directly.
using FileParts = std::span<const std::span<const uint8_t>>;
Status write_file(const std::filesystem::path& path, FileParts parts,
                  IfReadOnly if_read_only = IfReadOnly::kFail);
Status write_file(const std::filesystem::path& path, std::initializer_list<std::span<const uint8_t>> parts,
                  IfReadOnly if_read_only = IfReadOnly::kFail);

// An overload for the bytes that `write` writes. `write` returns false after an error, and leaves its errno.
Status write_file(const std::filesystem::path& path, const std::function<bool(std::FILE*)>& write,
                  IfReadOnly if_read_only = IfReadOnly::kFail);

// Writes a new file. Returns false and writes nothing if the name is taken.
Expected<bool> write_new_file(const std::filesystem::path& path, std::span<const uint8_t> bytes);

// Makes a folder and those above it, unless they exist. Errors: as for io_error.
Status make_folders(const std::filesystem::path& folder);

// What two paths of one file have in common: its whole path without links, as the file system compares names.
// Of a file that does not exist yet, the folders that do are followed.
std::string whole_name(const std::filesystem::path& path);

// What a path leads to if it is a link; that need not exist. Otherwise the path. Errors: kIo for a circle.
Expected<std::filesystem::path> follow_links(const std::filesystem::path& path);

}  // namespace psplit
