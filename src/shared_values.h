// Values that several threads read and write at once.
#pragma once

#include <atomic>
#include <cstdint>

namespace psplit {

// For a value that one body reads while another changes it, if either value is good enough. libc++ has no
// atomic_ref before version 19.
template <typename T>
T load_shared(const T& value) {
#ifdef __cpp_lib_atomic_ref
  return std::atomic_ref(const_cast<T&>(value)).load(std::memory_order_relaxed);
#else
  return __atomic_load_n(&value, __ATOMIC_RELAXED);
#endif
}
template <typename T>
void store_shared(T& value, T next) {
#ifdef __cpp_lib_atomic_ref
  std::atomic_ref(value).store(next, std::memory_order_relaxed);
#else
  __atomic_store_n(&value, next, __ATOMIC_RELAXED);
#endif
}

}  // namespace psplit
