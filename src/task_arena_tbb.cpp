#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>

#include "src/task_arena.h"

namespace psplit {

struct TaskArena::Threads {
  explicit Threads(int count) : thread_count(static_cast<size_t>(count)), arena(count) {
    // Lets the arena have more workers than cores when the user asks for that.
    if (thread_count > std::thread::hardware_concurrency())
      control.emplace(tbb::global_control::max_allowed_parallelism, thread_count);
  }
  const size_t thread_count;
  std::optional<tbb::global_control> control;
  tbb::task_arena arena;
};

TaskArena::TaskArena(int thread_count) : threads_(std::make_unique<Threads>(thread_count)) {}
TaskArena::~TaskArena() = default;

// A task of TBB for each thread takes tasks of `body` in their order. TBB itself would halve the range: one
// thread would begin with the first task, the other one in the middle, and the last to start might be a large
// one.
void TaskArena::run(size_t count, const std::function<void(size_t)>& body) {
  std::atomic<size_t> next = 0;
  const auto work = [&](size_t) {
    try {
      for (size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;) body(i);
    } catch (...) {
      next.store(count, std::memory_order_relaxed);
      throw;
    }
  };
  threads_->arena.execute([&] {
    tbb::parallel_for(size_t{0}, std::min(count, threads_->thread_count), work, tbb::simple_partitioner());
  });
}

}  // namespace psplit
