// Threads behind functions that look sequential. The number of threads never changes a result, because each
// call of a body writes only the elements of its own index.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "psplit/base.h"

namespace psplit {

// Runs body(i) for each i in [0, count) on any threads, roughly in order, and returns when all are done. A body
// may call it again, and it may be called by several threads at once. If a body throws, it throws that when no
// body runs any more. A pool counts the bodies: if one was dropped, or runs still, for_each throws
// std::logic_error, which is an error of loading or encoding. What still runs then uses memory that is gone.
using RunTasks = std::function<void(size_t count, const std::function<void(size_t)>& body)>;

// A pool of a fixed number of threads, which includes the calling thread. Thread-safe.
class PSPLIT_EXPORT ThreadPool {
 public:
  // 0 means one thread for each processor of the machine.
  explicit ThreadPool(int thread_count = 0);
  // Has no threads of its own: run_tasks runs the tasks, on the jobs of an engine for example, except a single
  // one, which is simply called. At most `thread_count` of them are expected to run at once; work is divided
  // for as many.
  ThreadPool(int thread_count, RunTasks run_tasks);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const;

  // Runs body(i) for each i in [0, count), and returns when all are done. Each index is one task, and tasks
  // start roughly in order: if their sizes differ, put the large ones first. A body may call this again. If
  // bodies throw, some tasks are left out, and one of the exceptions is thrown here.
  void for_each(size_t count, const std::function<void(size_t)>& body) const;

  // Runs body(begin, end) for consecutive ranges that cover [0, count). Each has about `grain` items.
  void for_ranges(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) const;

 private:
  struct Arena;
  std::unique_ptr<Arena> arena_;
};

}  // namespace psplit
