// The thread pool of a module with one thread: the calling thread does all work.
#include <algorithm>

#include "psplit/parallel.h"

namespace psplit {

struct ThreadPool::Arena {};

ThreadPool::ThreadPool(int) {}
ThreadPool::~ThreadPool() = default;

int ThreadPool::thread_count() const { return 1; }

void ThreadPool::for_each(size_t count, const std::function<void(size_t)>& body) const {
  for (size_t i = 0; i < count; ++i) body(i);
}

void ThreadPool::for_ranges(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) const {
  grain = std::max<size_t>(grain, 1);
  for (size_t begin = 0; begin < count; begin += grain) body(begin, std::min(count, begin + grain));
}

}  // namespace psplit
