#include "psplit/parallel.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "src/task_arena.h"

namespace psplit {

struct ThreadPool::Arena {
  int thread_count;
  std::optional<TaskArena> own{};  // with more than one thread
  RunTasks run_tasks{};            // if there are no threads of its own
};

ThreadPool::ThreadPool(int thread_count) : arena_(std::make_unique<Arena>()) {
  arena_->thread_count =
      thread_count > 0 ? thread_count : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (arena_->thread_count > 1) arena_->own.emplace(arena_->thread_count);
}
ThreadPool::ThreadPool(int thread_count, RunTasks run_tasks) : arena_(std::make_unique<Arena>()) {
  arena_->thread_count = std::max(1, thread_count);
  arena_->run_tasks = std::move(run_tasks);
}
ThreadPool::~ThreadPool() = default;

int ThreadPool::thread_count() const { return arena_->thread_count; }

void ThreadPool::for_each(size_t count, const std::function<void(size_t)>& body) const {
  if (count > 1 && arena_->run_tasks) {
    // The executor is the caller's. Values that a dropped task should have written would be taken for results.
    std::atomic<size_t> done{0};
    arena_->run_tasks(count, [&](size_t i) {
      body(i);
      done.fetch_add(1, std::memory_order_relaxed);
    });
    if (const size_t ran = done; ran != count)
      throw std::logic_error("the executor ran " + std::to_string(ran) + " of " + std::to_string(count) +
                             " tasks");
  } else if (count > 1 && arena_->own) {
    arena_->own->run(count, body);
  } else {
    for (size_t i = 0; i < count; ++i) body(i);
  }
}

void ThreadPool::for_ranges(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) const {
  grain = std::max<size_t>(grain, 1);
  const size_t range_count = (count + grain - 1) / grain;
  for_each(range_count, [&](size_t i) { body(i * grain, std::min(count, (i + 1) * grain)); });
}

}  // namespace psplit
