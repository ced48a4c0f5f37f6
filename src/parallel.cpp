#include "src/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <optional>
#include <thread>

namespace psplit {

struct ThreadPool::Arena {
  explicit Arena(int count) : thread_count(count), arena(count) {
    // Lets the arena have more workers than cores when the user asks for that.
    const auto wanted = static_cast<size_t>(count);
    if (wanted > std::thread::hardware_concurrency())
      control.emplace(tbb::global_control::max_allowed_parallelism, wanted);
  }
  int thread_count;
  std::optional<tbb::global_control> control;
  mutable tbb::task_arena arena;
};

ThreadPool::ThreadPool(int thread_count)
    : arena_(std::make_unique<Arena>(
          thread_count > 0 ? thread_count
                           : std::max(1, static_cast<int>(std::thread::hardware_concurrency())))) {}
ThreadPool::~ThreadPool() = default;

int ThreadPool::thread_count() const { return arena_->thread_count; }

void ThreadPool::for_each(size_t count, const std::function<void(size_t)>& body) const {
  if (arena_->thread_count == 1 || count < 2) {
    for (size_t i = 0; i < count; ++i) body(i);
    return;
  }
  arena_->arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, count, 1),
        [&](const tbb::blocked_range<size_t>& range) {
          for (size_t i = range.begin(); i != range.end(); ++i) body(i);
        },
        tbb::simple_partitioner());
  });
}

void ThreadPool::for_ranges(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) const {
  grain = std::max<size_t>(grain, 1);
  const size_t range_count = (count + grain - 1) / grain;
  for_each(range_count, [&](size_t i) { body(i * grain, std::min(count, (i + 1) * grain)); });
}

}  // namespace psplit
