// Services that the standard library lacks: file locks, terminals, signals, settings of the heap. All calls of
// POSIX and glibc are in operating_system.cpp (scripts/check-includes): a port to another system changes only
// it.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string_view>

#include "src/status.h"

namespace psplit {

// A new file, open for writing. It stays locked until it is closed or its process ends, even by a signal. Null
// if this fails. errno is then EEXIST if the name is taken, or if remove_if_unlocked removed the file
// meanwhile.
std::FILE* create_locked(const std::filesystem::path& path);

// Removes a file that no process has locked. The file stays if it cannot be locked.
void remove_if_unlocked(const std::filesystem::path& path);

// From now on, writing past the limit on a file's size (ulimit -f) fails instead of ending the process.
void let_writes_past_size_limit_fail();

// A file that grows by whole lines. One process at a time owns it, until the object is destroyed.
class LockedLog {
 public:
  LockedLog() = default;
  ~LockedLog();
  LockedLog(const LockedLog&) = delete;
  LockedLog& operator=(const LockedLog&) = delete;

  // Creates the file if it does not exist. False if another process owns it. Errors: kIo.
  Expected<bool> open(const std::filesystem::path& path);
  // Writes in one call, so that a kill damages the last line at most. Errors: kIo.
  Status append(std::string_view text) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

// Whether this process may create files in a folder.
bool may_write_into(const std::filesystem::path& folder);

bool is_terminal(std::FILE* stream);
// The width of the terminal. 0 if the stream is not a terminal, or if the width is unknown.
size_t terminal_columns(std::FILE* stream);

// Keeps the memory of freed large arrays for later use instead of returning it to the system. Does nothing if
// the C library has no such setting.
void keep_freed_memory();

}  // namespace psplit
