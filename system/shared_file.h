// Files that several processes have open at once, by their descriptors: what operating_system.h makes logs,
// locks and temporary files of. Each call is one of the system. After a failure, errno has the cause.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "psplit/base.h"

namespace psplit {

// A process that was killed keeps its locks until the system has freed its memory.
inline constexpr auto kLockPatience = std::chrono::seconds(2);
inline constexpr auto kLockRefresh = std::chrono::milliseconds(20);

// io_error of writing; kMayPass for the limit on a file's size, because another run may have a larger one.
Status space_error(const std::string& what, int error);

namespace shared_file {

enum class Access {
  kRead,    // the file must exist
  kWrite,   // it is made if it does not exist
  kAppend,  // made if it does not exist; each append() goes to its end, whichever processes write
};
// The descriptor, or -1.
int open(const std::filesystem::path& path, Access access);
void close(int descriptor);

enum class Lock { kAlone, kTogether };
// Whether the lock was taken. If another process holds it, errno is EWOULDBLOCK.
bool try_lock(int descriptor, Lock lock);
void unlock(int descriptor);

// The number of bytes that were read or written, which may be fewer; or -1.
int64_t read_at(int descriptor, uint64_t offset, std::span<uint8_t> to);
int64_t write_at(int descriptor, uint64_t offset, std::span<const uint8_t> bytes);
int64_t append(int descriptor, std::string_view text);

uint64_t size_of(int descriptor);
bool set_size(int descriptor, uint64_t bytes);
bool sync(int descriptor);  // to the disk

}  // namespace shared_file
}  // namespace psplit
