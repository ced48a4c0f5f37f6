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
  // Makes the memory at `bytes` at least `wanted` bytes large, where it is. Returns its new size, or 0.
  using Grow = size_t (*)(uint8_t* bytes, size_t wanted);

  Arena() = default;
  PSPLIT_HD Arena(uint8_t* bytes, size_t size) {
    const size_t skip = (kAlignment - reinterpret_cast<uintptr_t>(bytes) % kAlignment) % kAlignment;
    bytes_ = bytes + (skip < size ? skip : size);
    size_ = skip < size ? size - skip : 0;
  }
  // An arena in memory that grows on demand, to at most `most` bytes. `bytes` is aligned for vectors. Not for
  // devices.
  Arena(uint8_t* bytes, size_t size, size_t most, Grow more) : Arena(bytes, size) {
    most_ = most;
    more_ = more;
  }

  // Returns false, and leaves `out`, if too little memory is left. Products of counts from streams have 64
  // bits: a size_t of 32 bits would wrap.
  template <typename T>
  PSPLIT_HD bool take(View<T>& out, uint64_t count) {
    static_assert(alignof(T) <= kAlignment);
    const size_t start = aligned(used_);
    if ((start > size_ || count > (size_ - start) / sizeof(T)) && !grow(start, count, sizeof(T))) return false;
    out = View<T>(reinterpret_cast<T*>(bytes_ + start), static_cast<size_t>(count));
    used_ = start + static_cast<size_t>(count) * sizeof(T);
    return true;
  }

  // Takes an array that is never released. It may reuse the place of an array that was given back.
  template <typename T>
  PSPLIT_HD bool take_for_good(View<T>& out, uint64_t count) {
    if constexpr (kReuses) {
      for (Hole& hole : holes_) {
        if (hole.bytes / sizeof(T) < count) continue;
        out = View<T>(reinterpret_cast<T*>(bytes_ + hole.start), static_cast<size_t>(count));
        const size_t bytes = aligned(static_cast<size_t>(count) * sizeof(T));
        hole.start += bytes;
        hole.bytes -= bytes < hole.bytes ? bytes : hole.bytes;
        return true;
      }
    }
    return take(out, count);
  }
  // Gives back an array whose content is not needed any more. Memory that was taken before it must not be
  // released afterwards.
  template <typename T>
  PSPLIT_HD void give_back(View<T>& array) {
    if (!kReuses || array.empty()) return;
    Hole freed{static_cast<size_t>(reinterpret_cast<uint8_t*>(array.data()) - bytes_),
               array.size() * sizeof(T)};
    array = {};
    // It is joined with a hole before it, or replaces a smaller one.
    Hole* smallest = &holes_[0];
    for (Hole& hole : holes_) {
      if (hole.bytes > 0 && aligned(hole.start + hole.bytes) == freed.start) {
        hole.bytes = freed.start + freed.bytes - hole.start;
        return;
      }
      if (hole.bytes < smallest->bytes) smallest = &hole;
    }
    if (freed.bytes > smallest->bytes) *smallest = freed;
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
  // Takes again what was released, up to a mark of before.
  PSPLIT_HD void retake(size_t mark) { used_ = used_ < mark ? mark : used_; }

 private:
  struct Hole {
    size_t start = 0, bytes = 0;
  };
  static constexpr size_t kAlignment = 16;  // what vectors of 128 bits need
  static constexpr uint32_t kMostHoles = 4;
  static constexpr bool kReuses = !PSPLIT_MOVES_ROWS;  // a device saves registers

  PSPLIT_HD static constexpr size_t aligned(size_t at) {
    return (at + kAlignment - 1) / kAlignment * kAlignment;
  }
  PSPLIT_HD bool grow(size_t start, uint64_t count, size_t item_bytes) {
#if !defined(__CUDA_ARCH__)
    if (start > most_ || count > (most_ - start) / item_bytes) return false;
    const size_t size = more_(bytes_, start + static_cast<size_t>(count) * item_bytes);
    if (size != 0) size_ = size;
    return size != 0;
#else
    return false;
#endif
  }

  uint8_t* bytes_ = nullptr;
  size_t size_ = 0, used_ = 0;
  Hole holes_[kMostHoles];
  Grow more_ = nullptr;
  size_t most_ = 0;
};

template <typename T>
PSPLIT_HD void fill(View<T> view, T value) {
  if constexpr (sizeof(T) == 1) {
    if (!view.empty()) set_bytes(view.data(), static_cast<uint8_t>(value), view.size());
  } else {
    for (size_t i = 0; i < view.size(); ++i) view[i] = value;
  }
}
// Copies all values to the first places of another array. Compilers do not always see that a loop does only
// this.
template <typename T>
PSPLIT_HD void copy(View<const T> from, View<T> to) {
  PSPLIT_CORE_CHECK(from.size() <= to.size());
  if (!from.empty()) copy_bytes(to.data(), from.data(), from.size() * sizeof(T));
}

}  // namespace psplit::core
