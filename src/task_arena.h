// The implementation of ThreadPool's threads. PSPLIT_THREADS chooses the file that implements it:
// task_arena_tbb.cpp, or task_arena_std.cpp, which needs the standard library alone.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace psplit {

class TaskArena {
 public:
  // At most `thread_count` threads work at a time, callers of run included.
  explicit TaskArena(int thread_count);
  ~TaskArena();
  TaskArena(const TaskArena&) = delete;
  TaskArena& operator=(const TaskArena&) = delete;

  // Runs body(i) for each i in [0, count), roughly in order. A body may call it again. If bodies throw, some
  // tasks are left out, and one of the exceptions is thrown here when no body runs any more. Thread-safe.
  void run(size_t count, const std::function<void(size_t)>& body);

 private:
  struct Threads;
  std::unique_ptr<Threads> threads_;
};

}  // namespace psplit
