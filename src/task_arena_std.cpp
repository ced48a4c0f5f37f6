#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "src/task_arena.h"

namespace psplit {
namespace {

// A call of run. It lies on the caller's stack, so the caller waits for all that help.
struct Job {
  Job(size_t tasks, const std::function<void(size_t)>& task_body) : count(tasks), body(task_body) {}

  bool has_tasks() const { return next.load(std::memory_order_relaxed) < count; }
  // Takes tasks until there are none left.
  void work() {
    for (size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;) {
      try {
        body(i);
      } catch (...) {
        next.store(count, std::memory_order_relaxed);
        if (!has_failed.exchange(true)) error = std::current_exception();
      }
    }
  }

  const size_t count;
  const std::function<void(size_t)>& body;
  std::atomic<size_t> next{0};
  std::atomic<bool> has_failed{false};
  std::exception_ptr error{};  // of the one that failed first; read when nobody helps any more
  int helpers = 0;             // changes under the arena's lock, like the list of jobs
  std::condition_variable helper_left{};
};

}  // namespace

// Helpers begin with the latest job: it is the innermost, and others wait for it.
struct TaskArena::Threads {
  explicit Threads(int thread_count) : helper_count(static_cast<size_t>(thread_count) - 1) {}
  ~Threads() {
    {
      const std::lock_guard lock(mutex);
      ends = true;
    }
    wake.notify_all();
    for (std::thread& thread : threads) thread.join();
  }

  Job* find_job() const {
    const auto found =
        std::find_if(jobs.rbegin(), jobs.rend(), [](const Job* job) { return job->has_tasks(); });
    return found == jobs.rend() ? nullptr : *found;
  }
  void help() {
    std::unique_lock lock(mutex);
    for (;;) {
      Job* job = nullptr;
      wake.wait(lock, [&] { return ends || (job = find_job()) != nullptr; });
      if (job == nullptr) return;
      ++job->helpers;
      lock.unlock();
      job->work();
      lock.lock();
      if (--job->helpers == 0) job->helper_left.notify_one();
    }
  }
  // Wakes a helper for each task but the caller's own. Threads start with the first call that has use for them.
  void begin(Job& job) {
    const size_t wanted = std::min(helper_count, job.count - 1);
    {
      const std::lock_guard lock(mutex);
      while (threads.size() < wanted) threads.emplace_back([this] { help(); });
      jobs.push_back(&job);
    }
    for (size_t i = 0; i < wanted; ++i) wake.notify_one();
  }
  void finish(Job& job) {
    std::unique_lock lock(mutex);
    jobs.erase(std::find(jobs.begin(), jobs.end(), &job));
    job.helper_left.wait(lock, [&] { return job.helpers == 0; });
  }

  const size_t helper_count;
  std::mutex mutex;
  std::condition_variable wake;
  std::vector<Job*> jobs;
  std::vector<std::thread> threads;
  bool ends = false;
};

TaskArena::TaskArena(int thread_count) : threads_(std::make_unique<Threads>(std::max(1, thread_count))) {}
TaskArena::~TaskArena() = default;

void TaskArena::run(size_t count, const std::function<void(size_t)>& body) {
  if (count == 0) return;
  Job job(count, body);
  threads_->begin(job);
  job.work();
  threads_->finish(job);
  if (job.error) std::rethrow_exception(job.error);
}

}  // namespace psplit
