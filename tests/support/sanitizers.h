// Which sanitizers a build has: PSPLIT_ASAN and PSPLIT_TSAN are defined or not.
#pragma once

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
