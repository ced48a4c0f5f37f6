// A file that is written under a temporary name beside its target, and the removal of such files whose writer
// died.
#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>

#include "psplit/base.h"
#include "system/removed_at_stop.h"

namespace psplit {

// ".psplit-<16 hex digits>.part" beside `target`, whose own name may be as long as names can be; locked
// (system/operating_system.h) while it is open. The destructor closes and removes it, unless it was
// renamed; so does a signal (StopEndsProcess). The constructor first removes the files of dead writers from the
// folder, once per process and folder.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& target);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  bool is_open() const { return file_ != nullptr; }  // otherwise errno has the cause
  std::FILE* file() const { return file_; }
  const std::filesystem::path& path() const { return path_; }

  // The file must have been flushed. Errors: as for replace_file.
  Status rename_to(const std::filesystem::path& target);
  // Renames the file like rename_to, but fails with file_exists if the name is taken.
  std::error_code rename_to_new(const std::filesystem::path& target);

 private:
  std::filesystem::path path_;
  std::optional<RemovedAtStop> removed_at_stop_;
  std::FILE* file_ = nullptr;
};

// A new name for such a file beside `target`.
std::filesystem::path temporary_path(const std::filesystem::path& target);
// Whether a file name is that of a TemporaryFile: half of its digits are a hash of the others.
bool is_temporary_name(const std::filesystem::path& path);

// Removes the folder's temporary files that no process has locked.
void remove_dead_temporaries(const std::filesystem::path& folder);
// Calls remove_dead_temporaries once for each folder in a process: a batch writes thousands of files into one
// folder.
void remove_dead_temporaries_once(const std::filesystem::path& folder);

}  // namespace psplit
