// Parallel loops with a sequential interface. The number of threads never changes a result, because each call
// of a body writes only the elements of its own index.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "psplit/base.h"

namespace psplit {

// An executor of the caller's: must run body(i) for each i in [0, count) on any threads, roughly in order, and
// return when all are done. Bodies may call it again, and several threads may call it at once. If a body
// throws, it must rethrow the exception after all running bodies have ended. A pool counts the bodies: if the
// executor returns while one was not run, or still runs, for_each throws std::logic_error, which loading or
// encoding returns as an error. Bodies that still run then use freed memory.
using RunTasks = std::function<void(size_t count, const std::function<void(size_t)>& body)>;

// A pool of a fixed number of threads, including the calling one. Thread-safe.
class PSPLIT_EXPORT ThreadPool {
 public:
  // 0 means one thread for each processor of the machine.
  explicit ThreadPool(int thread_count = 0);
  // A pool without threads of its own: run_tasks runs the tasks, for example as jobs of an engine; a single
  // task is called directly. Work is divided for `thread_count` tasks at once.
  ThreadPool(int thread_count, RunTasks run_tasks);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const;

  // Runs body(i) for each i in [0, count), and returns when all are done. Each index is one task, and tasks
  // start roughly in order: if their sizes differ, put the large ones first. A body may call this again. If a
  // body throws, later tasks may be skipped, and one of the exceptions is rethrown.
  void for_each(size_t count, const std::function<void(size_t)>& body) const;

  // Runs body(begin, end) for consecutive ranges that cover [0, count). Each has about `grain` items.
  void for_ranges(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) const;

 private:
  struct Arena;
  std::unique_ptr<Arena> arena_;
};

}  // namespace psplit
