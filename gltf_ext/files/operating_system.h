// What the standard library lacks: locks on files, terminals, signals, the heap's settings. All calls of POSIX
// and of glibc are in operating_system.cpp (scripts/check-includes), for who ports psplit to another system.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string_view>

#include "src/status.h"

namespace psplit {

// A new file, open for writing and locked until it is closed or its process ends, however it ends. Null where
// that fails: errno is EEXIST where something has the name, or lost it to remove_if_unlocked meanwhile.
std::FILE* create_locked(const std::filesystem::path& path);

// Removes a file that no process holds locked. One that cannot be locked stays.
void remove_if_unlocked(const std::filesystem::path& path);

// Writing past the limit on a file's size (ulimit -f) fails from now on, and no longer ends the process.
void let_writes_past_size_limit_fail();

// A file that grows by whole lines, and that one process at a time has until it is destroyed.
class LockedLog {
 public:
  LockedLog() = default;
  ~LockedLog();
  LockedLog(const LockedLog&) = delete;
  LockedLog& operator=(const LockedLog&) = delete;

  // Makes the file where there is none. False where another process has it. Errors: kIo.
  Expected<bool> open(const std::filesystem::path& path);
  // In one call, so that a kill cuts no more than the last line. Errors: kIo.
  Status append(std::string_view text) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

// Whether this process has the permission to make files in a folder.
bool may_write_into(const std::filesystem::path& folder);

bool is_terminal(std::FILE* stream);

// Keeps memory that large arrays give back, instead of returning it to the system and asking for it again. Does
// nothing where the C library has no such setting.
void keep_freed_memory();

}  // namespace psplit
