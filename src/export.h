// PSPLIT_EXPORT marks the functions and classes that shared libraries export. All others are hidden in them.
// PSPLIT_HIDDEN is for members of an exported class.
#pragma once

#if defined(_WIN32) && defined(PSPLIT_BUILDS_SHARED)
#define PSPLIT_EXPORT __declspec(dllexport)
#elif defined(_WIN32) && defined(PSPLIT_SHARED)
#define PSPLIT_EXPORT __declspec(dllimport)
#elif defined(_WIN32)
#define PSPLIT_EXPORT
#else
#define PSPLIT_EXPORT [[gnu::visibility("default")]]
#endif

#if defined(_WIN32)
#define PSPLIT_HIDDEN
#else
#define PSPLIT_HIDDEN [[gnu::visibility("hidden")]]
#endif
