// Marks what shared libraries export: all else is hidden in them.
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
