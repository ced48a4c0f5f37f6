// What the modules export. All numbers are 32-bit words, and addresses are bytes of the module's memory.
//
// A handle is the address of a decoded stream or container, or 0 after an error: last_error then says why. The
// caller frees it. Functions that return "words" return the address of words that stay valid until the next
// call of the same function.
//
// If memory runs out, or if the stack overflows, the call traps, and the instance must not be used any more.
#pragma once

#include <memory>

#include "psplit/base.h"

#define PSPLIT_WEB_EXPORT(name) extern "C" [[clang::export_name(#name)]]

namespace psplit::web {

// Keeps an error for last_error. Returns whether the status is ok.
bool keep_error(Status status);

// The handle of what was made.
template <typename T>
T* handle_of(Expected<std::unique_ptr<T>> made) {
  return keep_error(made.status()) ? made->release() : nullptr;
}

// Memory of allocate that a call takes over.
inline std::unique_ptr<uint8_t[]> owned(uint8_t* bytes) { return std::unique_ptr<uint8_t[]>(bytes); }

}  // namespace psplit::web
