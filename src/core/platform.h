// Differences between compilers. The headers of the core build with g++, clang and nvcc, for the host and for
// the device. With these the core includes only <cstddef> and <cstdint>.
#pragma once

#include <cstddef>
#include <cstdint>

// PSPLIT_WITHOUT_BUILTINS: as for a compiler that lacks GCC's functions and vectors, such as Microsoft's.
#if (defined(__GNUC__) || defined(__clang__)) && !defined(PSPLIT_WITHOUT_BUILTINS)
#define PSPLIT_HAS_BUILTINS 1
#define PSPLIT_STANDARD(function) __builtin_##function  // a function of C's library
#else
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <bit>
#define PSPLIT_STANDARD(function) ::function
#endif

#if defined(__CUDACC__)
#define PSPLIT_HD __host__ __device__
#else
#define PSPLIT_HD
#endif

#if defined(PSPLIT_HAS_BUILTINS)
#define PSPLIT_LIKELY(x) __builtin_expect(!!(x), 1)
#define PSPLIT_UNLIKELY(x) __builtin_expect(!!(x), 0)
#else
#define PSPLIT_LIKELY(x) (x)
#define PSPLIT_UNLIKELY(x) (x)
#endif

// For a step of a run: the loop that takes the steps then keeps the state of the run in registers.
#if defined(__CUDACC__)
#define PSPLIT_INLINE __forceinline__
#elif defined(PSPLIT_HAS_BUILTINS)
#define PSPLIT_INLINE [[gnu::always_inline]] inline
#elif defined(_MSC_VER)
#define PSPLIT_INLINE __forceinline
#else
#define PSPLIT_INLINE inline
#endif

// Loads memory that is needed soon into the cache.
#if defined(__CUDA_ARCH__) || !defined(PSPLIT_HAS_BUILTINS)
#define PSPLIT_PREFETCH(address) ((void)sizeof(address))
#else
#define PSPLIT_PREFETCH(address) __builtin_prefetch(address)
#endif

// The pointer; tells the compiler that it is aligned.
#if defined(PSPLIT_HAS_BUILTINS)
#define PSPLIT_ASSUME_ALIGNED(pointer, alignment) __builtin_assume_aligned(pointer, alignment)
#else
#define PSPLIT_ASSUME_ALIGNED(pointer, alignment) (pointer)
#endif

// Selects code paths for devices that differ from a processor's. A device has few registers and stores for many
// threads at once, so it moves rows of a table whole, and stores nothing that is not needed. Host builds with
// PSPLIT_DEVICE_PATHS take these ways too, for tests: all code of a program must be built alike. Only
// instructions that a device alone has ask for __CUDA_ARCH__.
#if defined(__CUDA_ARCH__) || defined(PSPLIT_DEVICE_PATHS)
#define PSPLIT_MOVES_ROWS true
#else
#define PSPLIT_MOVES_ROWS false
#endif

// Before a loop over a few runs whose state is kept in registers.
#if defined(__CUDA_ARCH__)
#define PSPLIT_UNROLL _Pragma("unroll")
#elif defined(__CUDACC__) || !defined(PSPLIT_HAS_BUILTINS)
#define PSPLIT_UNROLL
#else
#define PSPLIT_UNROLL _Pragma("GCC unroll 8")
#endif

// Builds with PSPLIT_SMALL_CODE have less than half the code, and are a little slower: one width of numbers in
// the CPU's driver, and loops for all runs in step or for one run. For code that is sent over networks.
#if defined(PSPLIT_SMALL_CODE)
#define PSPLIT_IS_SMALL_CODE true
#else
#define PSPLIT_IS_SMALL_CODE false
#endif

// For what has enough work that a call costs little: small code has it once.
#if defined(PSPLIT_SMALL_CODE)
#define PSPLIT_ONCE_IF_SMALL [[gnu::noinline]]
#else
#define PSPLIT_ONCE_IF_SMALL
#endif

// Builds with PSPLIT_CORE_CHECKS stop at the first index out of bounds. Other builds rely on the explicit
// checks of what a stream says, and on tests and fuzzers that ran with PSPLIT_CORE_CHECKS.
#if defined(PSPLIT_CORE_CHECKS) && defined(__CUDA_ARCH__)
#define PSPLIT_CORE_CHECK(x) ((x) ? (void)0 : __trap())
#elif defined(PSPLIT_CORE_CHECKS) && defined(PSPLIT_HAS_BUILTINS)
#define PSPLIT_CORE_CHECK(x) ((x) ? (void)0 : __builtin_trap())
#elif defined(PSPLIT_CORE_CHECKS)
#define PSPLIT_CORE_CHECK(x) ((x) ? (void)0 : ::abort())
#else
#define PSPLIT_CORE_CHECK(x) ((void)0)
#endif

namespace psplit::core {

// A member that only devices use. Hosts have it too, because the host and the device must agree on where
// members are. Only small code, which no device runs, has an empty one.
template <bool kIsUsed, typename T>
struct MemberIf {
  using Type = T;
};
template <typename T>
struct MemberIf<false, T> {
  struct Type {};
};
template <typename T>
using ForDevices = typename MemberIf<!PSPLIT_IS_SMALL_CODE, T>::Type;

// A copy, which a device keeps in registers: it would load members again after each store. Or a reference.
template <bool kIsCopy, typename T>
struct CopyIf {
  using Type = T&;
};
template <typename T>
struct CopyIf<true, T> {
  using Type = T;
};

// The position of the highest set bit; 0 for 0.
PSPLIT_HD inline uint32_t floor_log2(uint32_t value) {
#if defined(__CUDA_ARCH__)
  return 31 - static_cast<uint32_t>(__clz(static_cast<int>(value | 1)));
#elif defined(PSPLIT_HAS_BUILTINS)
  return 31 - static_cast<uint32_t>(__builtin_clz(value | 1));
#else
  return 31 - static_cast<uint32_t>(std::countl_zero(value | 1));
#endif
}
// The position of the lowest set bit. `value` is not 0.
PSPLIT_HD inline uint32_t trailing_zeros(uint64_t value) {
#if defined(__CUDA_ARCH__)
  return static_cast<uint32_t>(__ffsll(static_cast<long long>(value))) - 1;
#elif defined(PSPLIT_HAS_BUILTINS)
  return static_cast<uint32_t>(__builtin_ctzll(value));
#else
  return static_cast<uint32_t>(std::countr_zero(value));
#endif
}

// The number of bits that are set.
PSPLIT_HD inline uint32_t bit_count(uint32_t value) {
#if defined(__CUDA_ARCH__)
  return static_cast<uint32_t>(__popc(static_cast<int>(value)));
#elif defined(__x86_64__) && !defined(__POPCNT__)
  // Without the instruction, the builtin is a call.
  value -= value >> 1 & 0x55555555;
  value = (value & 0x33333333) + (value >> 2 & 0x33333333);
  return ((value + (value >> 4)) & 0x0f0f0f0f) * 0x01010101 >> 24;
#elif defined(PSPLIT_HAS_BUILTINS)
  return static_cast<uint32_t>(__builtin_popcount(value));
#else
  return static_cast<uint32_t>(std::popcount(value));
#endif
}

// The bytes in the other order.
PSPLIT_HD inline uint64_t bytes_reversed(uint64_t value) {
#if defined(__CUDA_ARCH__)
  return uint64_t{__byte_perm(static_cast<uint32_t>(value), 0, 0x0123)} << 32 |
         __byte_perm(static_cast<uint32_t>(value >> 32), 0, 0x0123);
#elif defined(PSPLIT_HAS_BUILTINS)
  return __builtin_bswap64(value);
#else
  value = (value & 0x00ff00ff00ff00ff) << 8 | (value >> 8 & 0x00ff00ff00ff00ff);
  value = (value & 0x0000ffff0000ffff) << 16 | (value >> 16 & 0x0000ffff0000ffff);
  return value << 32 | value >> 32;
#endif
}

PSPLIT_HD PSPLIT_INLINE void copy_bytes(void* to, const void* from, size_t count) {
  PSPLIT_STANDARD(memcpy)(to, from, count);
}
PSPLIT_HD PSPLIT_INLINE void set_bytes(void* to, uint8_t value, size_t count) {
  PSPLIT_STANDARD(memset)(to, value, count);
}
PSPLIT_HD PSPLIT_INLINE bool equal_bytes(const void* a, const void* b, size_t count) {
  return PSPLIT_STANDARD(memcmp)(a, b, count) == 0;
}
PSPLIT_HD PSPLIT_INLINE float square_root(float value) { return PSPLIT_STANDARD(sqrtf)(value); }
PSPLIT_HD PSPLIT_INLINE double square_root(double value) { return PSPLIT_STANDARD(sqrt)(value); }
#if defined(__wasm_simd128__)
// The square roots of four numbers at once.
template <typename Floats>
Floats square_roots(Floats values) {
  return __builtin_wasm_sqrt_f32x4(values);
}
#endif

// Choices without branches. A mask is all ones if its condition holds, otherwise 0; select returns `a` for all
// ones.
PSPLIT_HD constexpr uint32_t mask(bool condition) { return 0u - static_cast<uint32_t>(condition); }
PSPLIT_HD constexpr uint32_t select(uint32_t if_set, uint32_t a, uint32_t b) { return b ^ ((a ^ b) & if_set); }

}  // namespace psplit::core
