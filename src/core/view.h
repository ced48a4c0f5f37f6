// The caller's memory: arrays with bounds, and the arena from which they are taken.
#pragma once

#include "src/core/platform.h"

namespace psplit::core {

template <typename T>
class View {
 public:
  View() = default;
  PSPLIT_HD View(T* data, size_t size) : data_(data), size_(size) {}
  // A read-only view of the same array.
  template <typename U>
  requires(static_cast<const U*>(static_cast<T*>(nullptr)) == nullptr) PSPLIT_HD View(View<U> other)
      : data_(other.data()), size_(other.size()) {}

  PSPLIT_HD T& operator[](size_t i) const {
    PSPLIT_CORE_CHECK(i < size_);
    return data_[i];
  }
  PSPLIT_HD T* data() const { return data_; }
  PSPLIT_HD size_t size() const { return size_; }
  PSPLIT_HD bool empty() const { return size_ == 0; }
  PSPLIT_HD View first(size_t count) const {
    PSPLIT_CORE_CHECK(count <= size_);
    return View(data_, count);
  }

 private:
  T* data_ = nullptr;
  size_t size_ = 0;
};

// Takes arrays from the caller's memory, one after the other. They are not initialized.
class Arena {
 public:
  Arena() = default;
  PSPLIT_HD Arena(uint8_t* bytes, size_t size) {
    const size_t skip = (kAlignment - reinterpret_cast<uintptr_t>(bytes) % kAlignment) % kAlignment;
    bytes_ = bytes + (skip < size ? skip : size);
    size_ = skip < size ? size - skip : 0;
  }

  // Returns false, and leaves `out`, if too little memory is left. Products of counts from streams have 64
  // bits: a size_t of 32 bits would wrap.
  template <typename T>
  PSPLIT_HD bool take(View<T>& out, uint64_t count) {
    static_assert(alignof(T) <= kAlignment);
    const size_t start = (used_ + kAlignment - 1) / kAlignment * kAlignment;
    if (start > size_ || count > (size_ - start) / sizeof(T)) return false;
    out = View<T>(reinterpret_cast<T*>(bytes_ + start), static_cast<size_t>(count));
    used_ = start + static_cast<size_t>(count) * sizeof(T);
    return true;
  }

  // The most bytes that take needs for `count` values of type T.
  template <typename T>
  PSPLIT_HD static constexpr size_t bytes(uint64_t count) {
    return static_cast<size_t>(count) * sizeof(T) + kAlignment - 1;
  }

  // `last` is the array that was taken last. Gives back all of it except the first `count` values.
  template <typename T>
  PSPLIT_HD void trim(View<T>& last, size_t count) {
    used_ -= (last.size() - count) * sizeof(T);
    last = last.first(count);
  }

  // release gives back all arrays that were taken after the mark.
  PSPLIT_HD size_t mark() const { return used_; }
  PSPLIT_HD void release(size_t mark) { used_ = mark; }

 private:
  static constexpr size_t kAlignment = 16;  // what vectors of 128 bits need

  uint8_t* bytes_ = nullptr;
  size_t size_ = 0, used_ = 0;
};

template <typename T>
PSPLIT_HD void fill(View<T> view, T value) {
  for (size_t i = 0; i < view.size(); ++i) view[i] = value;
}

}  // namespace psplit::core
