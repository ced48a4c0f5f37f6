#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <optional>
#include <thread>

#include "src/task_arena.h"

namespace psplit {

struct TaskArena::Threads {
  explicit Threads(int count) : arena(count) {
    // Lets the arena have more workers than cores when the user asks for that.
    const auto wanted = static_cast<size_t>(count);
    if (wanted > std::thread::hardware_concurrency())
      control.emplace(tbb::global_control::max_allowed_parallelism, wanted);
  }
  std::optional<tbb::global_control> control;
  tbb::task_arena arena;
};

TaskArena::TaskArena(int thread_count) : threads_(std::make_unique<Threads>(thread_count)) {}
TaskArena::~TaskArena() = default;

void TaskArena::run(size_t count, const std::function<void(size_t)>& body) {
  threads_->arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, count, 1),
        [&](const tbb::blocked_range<size_t>& range) {
          for (size_t i = range.begin(); i != range.end(); ++i) body(i);
        },
        tbb::simple_partitioner());
  });
}

}  // namespace psplit
