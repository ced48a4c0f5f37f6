// How many assets run at once, so that they fit into memory together.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

namespace psplit {

// Thread-safe. Assets begin in the order in which they ask, so that small ones do not hold up a large one.
class MemoryBudget {
 public:
  // 0: no limit.
  explicit MemoryBudget(uint64_t bytes) : limit_(bytes) {}

  // What an asset took. The destructor gives it back; the budget must outlive it.
  class Share {
   public:
    Share(MemoryBudget& budget, uint64_t bytes) : budget_(&budget), bytes_(bytes) {}
    Share(Share&& other) noexcept : budget_(std::exchange(other.budget_, nullptr)), bytes_(other.bytes_) {}
    Share& operator=(Share&&) = delete;
    ~Share() {
      if (budget_ != nullptr) budget_->give_back(bytes_);
    }

   private:
    MemoryBudget* budget_;
    uint64_t bytes_;
  };
  // Waits until the asset fits beside those that run. Calls `wait` before, if it has to. An asset that never
  // fits runs alone: the estimate may be too high, and the worker process protects the others.
  Share take(uint64_t bytes, const std::function<void()>& wait);

 private:
  void give_back(uint64_t bytes);

  const uint64_t limit_;
  std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t taken_ = 0;
  uint64_t next_ticket_ = 0, turn_ = 0;
};

}  // namespace psplit
