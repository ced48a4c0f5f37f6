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

// Builds with PSPLIT_CORE_CHECKS stop at the first index out of bounds. Others rely on what tests and fuzzers
// showed with it, and on the checks of everything that a stream says.
#if defined(PSPLIT_CORE_CHECKS)
#define PSPLIT_CORE_CHECK(x) ((x) ? (void)0 : __builtin_trap())
#else
#define PSPLIT_CORE_CHECK(x) ((void)0)
#endif
