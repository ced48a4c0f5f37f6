// Threads behind sequential names. The number of threads never changes a result: bodies write only what
// belongs to their index.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace psplit {

// A pool of a fixed number of threads, the caller's included. Safe to share between threads.
class ThreadPool {
 public:
  // 0 threads means as many as the machine has.
  explicit ThreadPool(int thread_count = 0);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const;

  // Runs body(i) for every i in [0, count) and returns when all are done. Indices start roughly in order and
  // each is one task, so pass the large ones first where sizes differ.
  void for_each(size_t count, const std::function<void(size_t)>& body) const;

  // Runs body(begin, end) over consecutive ranges that cover [0, count), each of about `grain` items.
  void for_ranges(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) const;

 private:
  struct Arena;
  std::unique_ptr<Arena> arena_;
};

// For values that bodies look at while others change them, where any of the values will do.
inline uint32_t load_shared(const uint32_t& value) {
  return std::atomic_ref(const_cast<uint32_t&>(value)).load(std::memory_order_relaxed);
}
inline void store_shared(uint32_t& value, uint32_t next) {
  std::atomic_ref(value).store(next, std::memory_order_relaxed);
}

}  // namespace psplit
