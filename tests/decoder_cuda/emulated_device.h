// A device on the host: threads and warps of a launch one after the other, in an order of the test's choice,
// the lanes of warps as the emulated warp runs them. Its memory is poisoned, so that nobody relies on zeros.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "src/status.h"
#include "tests/support/emulated_warp.h"

namespace psplit {

class EmulatedDevice {
 public:
  template <typename T>
  class Array {
   public:
    Status reserve(size_t count) {
      if (count <= count_) return {};
      // Just as many bytes: the address sanitizer sees one too many.
      bytes_ = std::make_unique_for_overwrite<std::byte[]>(count * sizeof(T));
      std::memset(bytes_.get(), 0xa5, count * sizeof(T));
      count_ = count;
      return {};
    }
    T* data() const { return reinterpret_cast<T*>(bytes_.get()); }

   private:
    std::unique_ptr<std::byte[]> bytes_;
    size_t count_ = 0;
  };

  explicit EmulatedDevice(LaneOrder order = {}) : order_(order), random_(order.seed) {}

  template <typename T>
  Status upload(Array<T>& array, std::span<const T> values) {
    (void)array.reserve(values.size());
    if (!values.empty()) std::memcpy(static_cast<void*>(array.data()), values.data(), values.size_bytes());
    return {};
  }
  template <typename T>
  Status download(T* out, const T* data, size_t count) {
    if (count > 0) std::memcpy(static_cast<void*>(out), data, count * sizeof(T));
    return {};
  }
  template <typename Body>
  Status launch_threads(uint32_t count, const Body& body) {
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

 private:
  std::vector<uint32_t> in_order(uint32_t count) {
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
