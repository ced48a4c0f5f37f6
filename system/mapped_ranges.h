// The mapped files of this process, for handlers that say which file failed.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <span>

namespace psplit {

// A mapped file. A handler of signals or exceptions reads it: `end` is 0 while the other members change.
struct MappedRange {
  std::atomic<uintptr_t> begin = 0, end = 0;
  std::atomic<const char*> name = nullptr;  // in UTF-8 on Windows
  void* file = nullptr;                     // the caller's

  bool contains(uintptr_t address) const {
    const uintptr_t last = end.load(std::memory_order_acquire);
    return address < last && address >= begin.load(std::memory_order_relaxed);
  }
};

// The file at an address, or null. A handler of signals may call it.
const MappedRange* mapped_range_at(uintptr_t address);

// Enters a file after it was mapped. The first one calls `install`, which installs a handler. False if there
// are too many mapped files already. Thread-safe, as is leave_mapped.
bool enter_mapped(std::span<const uint8_t> bytes, const std::filesystem::path& path, void* file,
                  void (*install)());

// Removes a file before it is unmapped; nobody uses it any more. The last one calls `uninstall`. Returns the
// caller's `file`.
void* leave_mapped(std::span<const uint8_t> bytes, void (*uninstall)());

}  // namespace psplit
