// A file that is written beside the one that it is to become, and what is left of those whose writers died.
#pragma once

#include <cstdio>
#include <filesystem>
#include <system_error>

namespace psplit {

// "x.glb.psplit-<16 hex digits>.part" beside `target`, locked (gltf_ext/files/operating_system.h) while it is
// open. Closed and removed with the object, unless it was renamed. What dead writers left in the folder is
// removed first, once a process and folder.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& target);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  bool is_open() const { return file_ != nullptr; }  // otherwise errno says why
  std::FILE* file() const { return file_; }
  const std::filesystem::path& path() const { return path_; }

  // The file is flushed already.
  std::error_code rename_to(const std::filesystem::path& target);
  // The same, and file_exists where something has the name.
  std::error_code rename_to_new(const std::filesystem::path& target);

 private:
  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
};

// Whether a name is of a TemporaryFile: half of its digits are a hash of all else, which no other file has.
bool is_temporary_name(const std::filesystem::path& path);

// Removes the folder's temporary files that nobody holds a lock on.
void remove_dead_temporaries(const std::filesystem::path& folder);

}  // namespace psplit
