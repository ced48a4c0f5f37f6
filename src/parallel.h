// Threads behind sequential names. The number of threads never changes a result: bodies write only what
// belongs to their index.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "src/export.h"

namespace psplit {

// A pool of a fixed number of threads, the caller's included. Safe to share between threads.
class PSPLIT_EXPORT ThreadPool {
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

// For values that bodies look at while others change them, where any of the values will do. libc++ has no
// atomic_ref before version 19.
inline uint32_t load_shared(const uint32_t& value) {
#ifdef __cpp_lib_atomic_ref
  return std::atomic_ref(const_cast<uint32_t&>(value)).load(std::memory_order_relaxed);
#else
  return __atomic_load_n(&value, __ATOMIC_RELAXED);
#endif
}
inline void store_shared(uint32_t& value, uint32_t next) {
#ifdef __cpp_lib_atomic_ref
  std::atomic_ref(value).store(next, std::memory_order_relaxed);
#else
  __atomic_store_n(&value, next, __ATOMIC_RELAXED);
#endif
}

}  // namespace psplit
