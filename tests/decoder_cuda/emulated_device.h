// A device on the host. Threads and warps of a launch run one after the other, in an order that the test
// chooses, and the emulated warp runs the lanes. Its memory is poisoned, so that code that relies on zeros
// fails.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "tests/support/emulated_warp.h"

namespace psplit {

class EmulatedDevice {
  template <typename T, bool kOnHost>
  class Memory {
   public:
    Memory() = default;
    Memory(Memory&& other) noexcept : bytes_(std::move(other.bytes_)), count_(std::exchange(other.count_, 0)) {}
    Memory& operator=(Memory&& other) noexcept {
      std::swap(bytes_, other.bytes_);
      std::swap(count_, other.count_);
      return *this;
    }
    ~Memory() { release(); }

    Status reserve(size_t count) {
      if (count <= count_) return {};
      release();
      ++work().reservations;
      if (!kOnHost && bytes_in_use() + count * sizeof(T) > memory()) return runtime_failure("out of memory");
      // Exactly as many bytes as requested, so that the address sanitizer sees any access past them.
      bytes_ = std::make_unique_for_overwrite<std::byte[]>(count * sizeof(T));
      std::memset(bytes_.get(), 0xa5, count * sizeof(T));
      count_ = count;
      if (!kOnHost) bytes_in_use() += count * sizeof(T);
      most_bytes_in_use() = std::max(most_bytes_in_use(), bytes_in_use());
      return {};
    }
    T* data() const { return reinterpret_cast<T*>(bytes_.get()); }
    size_t size() const { return count_; }

   private:
    void release() {
      if (!kOnHost) bytes_in_use() -= count_ * sizeof(T);
      bytes_ = nullptr;
      count_ = 0;
    }

    std::unique_ptr<std::byte[]> bytes_;
    size_t count_ = 0;
  };

 public:
  template <typename T>
  using Array = Memory<T, false>;
  template <typename T>
  using HostArray = Memory<T, true>;

  // The size of the memory of all devices together, and the part of it in use.
  static size_t& memory() {
    static size_t bytes = ~size_t{0};
    return bytes;
  }
  static size_t& bytes_in_use() {
    static size_t bytes = 0;
    return bytes;
  }

  static size_t& most_bytes_in_use() {
    static size_t bytes = 0;
    return bytes;
  }
  // The work of all devices together.
  struct Work {
    size_t uploaded_bytes = 0, downloads = 0, launches = 0, reservations = 0;
    uint32_t most_items = 0;  // of a launch
  };
  static Work& work() {
    static Work work;
    return work;
  }

  explicit EmulatedDevice(LaneOrder order = {}) : order_(order), random_(order.seed) {}

  template <typename T>
  Status upload(T* to, const T* from, size_t count) {
    work().uploaded_bytes += count * sizeof(T);
    return copy(to, from, count);
  }
  template <typename T>
  Status download(T* to, const T* from, size_t count) {
    ++work().downloads;
    return copy(to, from, count);
  }
  template <typename Body>
  Status launch_threads(uint32_t count, uint32_t, const Body& body) {
    for (const uint32_t i : in_order(count)) body(i);
    return {};
  }
  template <typename Body>
  Status launch_warps(uint32_t count, const Body& body) {
    for (const uint32_t i : in_order(count)) run_warp([&](EmulatedLanes lanes) { body(lanes, i); }, order_);
    return {};
  }
  void mark(const char*) {}
  Status wait() { return {}; }
  uint64_t free_memory() const { return memory() - bytes_in_use(); }

 private:
  template <typename T>
  static Status copy(T* to, const T* from, size_t count) {
    if (count > 0) std::memcpy(static_cast<void*>(to), from, count * sizeof(T));
    return {};
  }
  std::vector<uint32_t> in_order(uint32_t count) {
    ++work().launches;
    work().most_items = std::max(work().most_items, count);
    std::vector<uint32_t> items(count);
    std::iota(items.begin(), items.end(), 0u);
    if (order_.kind == LaneOrder::kDescending) std::reverse(items.begin(), items.end());
    if (order_.kind == LaneOrder::kShuffled) std::shuffle(items.begin(), items.end(), random_);
    return items;
  }

  LaneOrder order_;
  std::mt19937_64 random_;
};

}  // namespace psplit
