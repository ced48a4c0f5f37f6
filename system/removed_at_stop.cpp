#include "system/removed_at_stop.h"

#include <array>
#include <cstdlib>
#include <cstring>

namespace psplit {
namespace {

// The names of the files. A thread that takes a name out of its place owns it.
constexpr size_t kMostRemovedAtStop = 64;
std::array<std::atomic<const char*>, kMostRemovedAtStop> removed_at_stop;

}  // namespace

char* copy_of_text(const std::string& text) {
  const size_t size = text.size() + 1;
  void* const copy = std::malloc(size);
  return copy == nullptr ? nullptr : static_cast<char*>(std::memcpy(copy, text.c_str(), size));
}

RemovedAtStop::RemovedAtStop(const std::filesystem::path& path) {
  char* const name = copy_of_text(path.string());
  if (name == nullptr) return;
  for (std::atomic<const char*>& place : removed_at_stop) {
    const char* free = nullptr;
    if (!place.compare_exchange_strong(free, name)) continue;
    place_ = &place;
    return;
  }
  std::free(name);
}

RemovedAtStop::~RemovedAtStop() {
  if (place_ != nullptr) std::free(const_cast<char*>(place_->exchange(nullptr)));
}

void RemovedAtStop::remove_all(void (*remove)(const char*)) {
  for (std::atomic<const char*>& place : removed_at_stop)
    if (const char* name = place.exchange(nullptr)) remove(name);
}

}  // namespace psplit
