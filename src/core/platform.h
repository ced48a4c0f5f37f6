// What the core needs to know about its compiler: the same headers build under g++, clang and nvcc, for the
// host and for the device. The core includes <cstddef> and <cstdint> only.
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(__CUDACC__)
#define PSPLIT_HD __host__ __device__
#else
#define PSPLIT_HD
#endif

#if defined(__GNUC__) || defined(__clang__)
#define PSPLIT_LIKELY(x) __builtin_expect(!!(x), 1)
#define PSPLIT_UNLIKELY(x) __builtin_expect(!!(x), 0)
#else
#define PSPLIT_LIKELY(x) (x)
#define PSPLIT_UNLIKELY(x) (x)
#endif

// Before a loop over a few things whose state is to live in registers.
#if defined(__CUDACC__)
#define PSPLIT_UNROLL _Pragma("unroll")
#else
#define PSPLIT_UNROLL _Pragma("GCC unroll 8")
#endif

// Builds with PSPLIT_CORE_CHECKS stop at the first index out of bounds. Others rely on what tests and fuzzers
// showed with it, and on the checks of everything that a stream says.
#if defined(PSPLIT_CORE_CHECKS)
#define PSPLIT_CORE_CHECK(x) ((x) ? (void)0 : __builtin_trap())
#else
#define PSPLIT_CORE_CHECK(x) ((void)0)
#endif

namespace psplit::core {

// Choices without branches: all ones where the condition holds, and what that selects.
PSPLIT_HD constexpr uint32_t mask(bool condition) { return 0u - static_cast<uint32_t>(condition); }
PSPLIT_HD constexpr uint32_t select(uint32_t if_set, uint32_t a, uint32_t b) { return b ^ ((a ^ b) & if_set); }

template <typename T>
struct Bare;
template <typename T>
struct Bare<T&> {
  using Type = T;
};

// Takes a step of each of kCount runs in turn until the first has none left. run_at(n) is the n-th; copies of
// them are stepped, which may live in registers.
template <uint32_t kCount, typename RunAt>
PSPLIT_HD void step_together(RunAt run_at) {
  using Run = typename Bare<decltype(run_at(0))>::Type;
  Run runs[kCount];
  bool all = true;
  for (uint32_t n = 0; n < kCount; ++n) {
    runs[n] = run_at(n);
    all &= runs[n].running();
  }
  while (all) {
    PSPLIT_UNROLL
    for (Run& run : runs) {
      run.step();
      all &= run.running();
    }
  }
  for (uint32_t n = 0; n < kCount; ++n) run_at(n) = runs[n];
}

}  // namespace psplit::core
