#include "system/mapped_ranges.h"

#include <array>
#include <cstdlib>
#include <mutex>
#include <string>
#include <utility>

#include "system/removed_at_stop.h"

namespace psplit {
namespace {

constexpr size_t kMostMappedFiles = 256;  // more files than that are read
std::array<MappedRange, kMostMappedFiles> mapped_ranges;
std::mutex mapping_mutex;  // of changes to the ranges, the count and the handler
size_t mapped_count = 0;

}  // namespace

const MappedRange* mapped_range_at(uintptr_t address) {
  for (const MappedRange& range : mapped_ranges)
    if (range.contains(address)) return &range;
  return nullptr;
}

bool enter_mapped(std::span<const uint8_t> bytes, const std::filesystem::path& path, void* file,
                  void (*install)()) {
  const std::lock_guard lock(mapping_mutex);
  for (MappedRange& range : mapped_ranges) {
    if (range.end.load(std::memory_order_relaxed) != 0) continue;
    const char* name = copy_of_text(path.string());
    if (name == nullptr) return false;
    const auto begin = reinterpret_cast<uintptr_t>(bytes.data());
    range.begin.store(begin, std::memory_order_relaxed);
    range.name.store(name, std::memory_order_relaxed);
    range.file = file;
    range.end.store(begin + bytes.size(), std::memory_order_release);
    if (mapped_count++ == 0) install();
    return true;
  }
  return false;
}

void* leave_mapped(std::span<const uint8_t> bytes, void (*uninstall)()) {
  const std::lock_guard lock(mapping_mutex);
  const auto begin = reinterpret_cast<uintptr_t>(bytes.data());
  for (MappedRange& range : mapped_ranges) {
    if (range.end.load(std::memory_order_relaxed) == 0 || range.begin.load(std::memory_order_relaxed) != begin)
      continue;
    range.end.store(0, std::memory_order_release);
    std::free(const_cast<char*>(range.name.exchange(nullptr)));
    if (--mapped_count == 0) uninstall();
    return std::exchange(range.file, nullptr);
  }
  return nullptr;
}

}  // namespace psplit
