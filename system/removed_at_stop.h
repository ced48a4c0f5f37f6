// Files that go if a signal ends the process.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>

namespace psplit {

// A copy for std::free; null if there is no memory. A handler of signals may read it.
char* copy_of_text(const std::string& text);

// A file that StopEndsProcess removes at a signal. Thread-safe. There are places for 64 files at a time; others
// stay until remove_if_unlocked finds them.
class RemovedAtStop {
 public:
  explicit RemovedAtStop(const std::filesystem::path& path);
  ~RemovedAtStop();
  RemovedAtStop(const RemovedAtStop&) = delete;
  RemovedAtStop& operator=(const RemovedAtStop&) = delete;

  // Calls remove(name) for each file, in UTF-8 on Windows. A handler of signals may call it.
  static void remove_all(void (*remove)(const char*));

 private:
  std::atomic<const char*>* place_ = nullptr;
};

}  // namespace psplit
