// Locks on open files, and signals about files: what the standard library lacks. POSIX.
#pragma once

#include <cstdio>
#include <filesystem>

namespace psplit {

// A new file, open for writing and locked until it is closed or its process ends, however it ends. Null where
// that fails: errno is EEXIST where something has the name, or lost it to remove_if_unlocked meanwhile.
std::FILE* create_locked(const std::filesystem::path& path);

// Removes a file that no process holds locked. One that cannot be locked stays.
void remove_if_unlocked(const std::filesystem::path& path);

// Writing past the limit on a file's size (ulimit -f) fails from now on, and no longer ends the process.
void let_writes_past_size_limit_fail();

}  // namespace psplit
