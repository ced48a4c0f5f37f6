// Which sanitizers a build has: PSPLIT_ASAN and PSPLIT_TSAN are defined or not.
#pragma once

#include <cstddef>
#include <cstdlib>

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

#if defined(PSPLIT_ASAN) || defined(PSPLIT_TSAN)
inline constexpr bool kHasSanitizers = true;
#else
inline constexpr bool kHasSanitizers = false;
#endif

// How many of `count` random mutants a test tries, or how large a mesh is. Sanitizers make each step many times
// slower, so they see a tenth; the build without sanitizers sees all, and the fuzzers try others.
constexpr size_t fewer_with_sanitizers(size_t count) { return kHasSanitizers ? count / 10 : count; }

// How many random cases a test tries where each is compared with libdraco: as many as above, times
// PSPLIT_TEST_ROUNDS of the environment. So the same test can run for hours.
inline size_t random_rounds(size_t count) {
  const char* const times = std::getenv("PSPLIT_TEST_ROUNDS");
  return fewer_with_sanitizers(count) * (times == nullptr ? 1 : std::strtoull(times, nullptr, 10));
}

}  // namespace psplit
