// Which sanitizers a build has: PSPLIT_ASAN and PSPLIT_TSAN are defined or not.
#pragma once

#include <cstddef>

#if defined(__has_feature)
#define PSPLIT_HAS_FEATURE(x) __has_feature(x)
#else
#define PSPLIT_HAS_FEATURE(x) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || PSPLIT_HAS_FEATURE(address_sanitizer)
#define PSPLIT_ASAN
#endif
#if defined(__SANITIZE_THREAD__) || PSPLIT_HAS_FEATURE(thread_sanitizer)
#define PSPLIT_TSAN
#endif

namespace psplit {

// How many of `count` random mutants a test tries, or how large a mesh is. Sanitizers make each step many times
// slower, so they see a tenth; the build without sanitizers sees all, and the fuzzers try others.
constexpr size_t fewer_with_sanitizers(size_t count) {
#if defined(PSPLIT_ASAN) || defined(PSPLIT_TSAN)
  return count / 10;
#else
  return count;
#endif
}

}  // namespace psplit
