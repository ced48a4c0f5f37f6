#include "tools/gltf_psplit/batch/memory_budget.h"

#include <algorithm>

namespace psplit {

MemoryBudget::Share MemoryBudget::take(uint64_t bytes, const std::function<void()>& wait) {
  if (limit_ != 0) bytes = std::min(bytes, limit_);  // it runs alone
  std::unique_lock lock(mutex_);
  const uint64_t ticket = next_ticket_++;
  const auto fits = [&] { return ticket == turn_ && (limit_ == 0 || taken_ + bytes <= limit_); };
  if (!fits()) {
    wait();
    changed_.wait(lock, fits);
  }
  ++turn_;
  taken_ += bytes;
  changed_.notify_all();
  return Share(*this, bytes);
}

void MemoryBudget::give_back(uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  taken_ -= bytes;
  changed_.notify_all();
}

}  // namespace psplit
