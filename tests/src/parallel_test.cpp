// Threads: each runner of this file has another arena (tests/CMakeLists.txt), with a sanitizer for races.
#include "psplit/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace psplit {
namespace {

TEST(ThreadPool, RunsEachTaskOnce) {
  for (const int threads : {1, 2, 3, 8}) {
    const ThreadPool pool(threads);
    EXPECT_EQ(pool.thread_count(), threads);
    for (const size_t count : {0u, 1u, 2u, 7u, 1000u}) {
      std::vector<int> runs(count);  // not atomic: each task has its own
      pool.for_each(count, [&](size_t i) { ++runs[i]; });
      EXPECT_EQ(std::accumulate(runs.begin(), runs.end(), size_t{0}), count);
      EXPECT_TRUE(std::all_of(runs.begin(), runs.end(), [](int times) { return times == 1; }));
    }
  }
  EXPECT_EQ(ThreadPool(0).thread_count(), std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
}

TEST(ThreadPool, DividesIntoRanges) {
  const ThreadPool pool(4);
  for (const size_t grain : {0u, 1u, 3u, 10u, 50u}) {
    std::vector<int> runs(25);
    pool.for_ranges(runs.size(), grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) ++runs[i];
    });
    EXPECT_EQ(runs, std::vector<int>(25, 1));
  }
}

// Two tasks that wait for each other need two threads.
TEST(ThreadPool, RunsTasksAtOnce) {
  const ThreadPool pool(2);
  std::atomic<int> here{0};
  pool.for_each(2, [&](size_t) {
    ++here;
    while (here < 2) std::this_thread::yield();
  });
  EXPECT_EQ(here, 2);
}

// While one thread has the first task, the other one takes the rest.
TEST(ThreadPool, StartsTasksInTheirOrder) {
  const ThreadPool pool(2);
  std::atomic<size_t> started{0};
  std::vector<size_t> order(9);
  pool.for_each(order.size(), [&](size_t i) {
    order[started++] = i;
    while (i == 0 && started < order.size()) std::this_thread::yield();
  });
  std::erase(order, size_t{0});  // it may be late
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(ThreadPool, HasNoMoreThreadsThanItSays) {
  const ThreadPool pool(3);
  std::mutex mutex;
  std::set<std::thread::id> ids;
  std::atomic<int> now{0}, most{0};
  pool.for_each(200, [&](size_t) {
    const int busy = ++now;
    for (int seen = most; busy > seen && !most.compare_exchange_weak(seen, busy);) continue;
    {
      const std::lock_guard lock(mutex);
      ids.insert(std::this_thread::get_id());
    }
    std::this_thread::yield();
    --now;
  });
  EXPECT_LE(most, 3);
  EXPECT_GE(ids.size(), 1u);
}

TEST(ThreadPool, Nests) {
  for (const int threads : {2, 4}) {
    const ThreadPool pool(threads);
    std::vector<std::vector<int>> runs(20, std::vector<int>(60));
    pool.for_each(20, [&](size_t i) {
      pool.for_each(30, [&](size_t j) { pool.for_each(2, [&](size_t k) { ++runs[i][2 * j + k]; }); });
    });
    for (const std::vector<int>& row : runs) EXPECT_EQ(row, std::vector<int>(60, 1));
  }
}

TEST(ThreadPool, ServesSeveralCallers) {
  const ThreadPool pool(3);
  std::vector<std::thread> callers;
  std::vector<size_t> sums(6);
  for (size_t caller = 0; caller < sums.size(); ++caller)
    callers.emplace_back([&, caller] {
      for (int round = 0; round < 50; ++round) {
        std::atomic<size_t> sum{0};
        pool.for_each(20, [&](size_t i) { sum += i; });
        sums[caller] += sum;
      }
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sums, std::vector<size_t>(6, size_t{50} * 190));
}

TEST(ThreadPool, ThrowsWhatATaskThrows) {
  for (const int threads : {1, 2, 4}) {
    const ThreadPool pool(threads);
    for (int round = 0; round < 20; ++round) {
      std::atomic<int> running{0};
      try {
        pool.for_each(100, [&](size_t i) {
          ++running;
          if (i % 10 == 3) {
            --running;
            throw std::runtime_error("task " + std::to_string(i));
          }
          --running;
        });
        FAIL() << "nothing was thrown";
      } catch (const std::runtime_error& error) {
        EXPECT_EQ(std::string(error.what()).substr(0, 5), "task ");
      }
      EXPECT_EQ(running, 0);  // nothing runs any more
    }
    int runs = 0;
    pool.for_each(1, [&](size_t) { ++runs; });
    EXPECT_EQ(runs, 1);  // the pool is as before
  }
}

TEST(ThreadPool, ThrowsThroughNesting) {
  const ThreadPool pool(3);
  EXPECT_THROW(pool.for_each(10,
                             [&](size_t i) {
                               pool.for_each(10, [&](size_t j) {
                                 if (i == 4 && j == 7) throw std::runtime_error("inner");
                               });
                             }),
               std::runtime_error);
}

// Without the count, values that nobody wrote would be taken for results.
TEST(ThreadPool, NoticesTasksThatTheCallersExecutorDrops) {
  const ThreadPool dropping(4, [](size_t count, const std::function<void(size_t)>& body) {
    for (size_t i = 0; i + 1 < count; ++i) body(i);
  });
  int runs = 0;
  try {
    dropping.for_each(7, [&](size_t) { ++runs; });
    FAIL() << "nothing was thrown";
  } catch (const std::logic_error& error) {
    EXPECT_STREQ(error.what(), "the executor ran 6 of 7 tasks");
  }
  EXPECT_EQ(runs, 6);
}

// An engine's jobs in place of threads.
TEST(ThreadPool, GivesTasksToTheCallersExecutor) {
  std::vector<size_t> calls;
  const ThreadPool pool(4, [&](size_t count, const std::function<void(size_t)>& body) {
    calls.push_back(count);
    for (size_t i = count; i-- > 0;) body(i);
  });
  EXPECT_EQ(pool.thread_count(), 4);
  std::vector<size_t> order;
  pool.for_each(3, [&](size_t i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<size_t>{2, 1, 0}));
  pool.for_ranges(10, 5, [&](size_t begin, size_t) { order.push_back(begin); });
  EXPECT_EQ(order, (std::vector<size_t>{2, 1, 0, 5, 0}));
  EXPECT_EQ(calls, (std::vector<size_t>{3, 2}));
}

// So that it may leave tasks out where there is one thread too.
TEST(ThreadPool, GivesTasksToAnExecutorOfOneThread) {
  std::vector<size_t> calls;
  const ThreadPool pool(1, [&](size_t count, const std::function<void(size_t)>& body) {
    calls.push_back(count);
    for (size_t i = 0; i < count; ++i) body(i);
  });
  int runs = 0;
  pool.for_each(3, [&](size_t) { ++runs; });
  EXPECT_EQ(calls, (std::vector<size_t>{3}));
  EXPECT_EQ(runs, 3);
}

TEST(ThreadPool, EndsWithoutUse) {
  for (int i = 0; i < 20; ++i) ThreadPool pool(8);
  for (int i = 0; i < 20; ++i) {
    const ThreadPool pool(4);
    pool.for_each(2, [](size_t) {});
  }
}

}  // namespace
}  // namespace psplit
