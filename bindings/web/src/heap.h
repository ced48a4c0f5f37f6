// The module's heap: all memory after its static data. It grows with the memory, and never shrinks: a page that
// wants the memory back drops the instance.
#pragma once

#include <cstddef>

namespace psplit::web {

// Returns memory that is aligned for every type, not zeroed; null if the memory cannot grow.
void* allocate(size_t bytes);
// Like the function above, but takes memory after all other memory in use, so that it can grow.
void* allocate_last(size_t bytes);
// Changes the size of memory of allocate, where it is. Returns false if there is no room.
bool resize(void* memory, size_t bytes);
// Gives back memory of allocate. Null is allowed.
void release(void* memory);

}  // namespace psplit::web
