// Large blocks of memory that are filled once and soon freed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace psplit {

struct FreeScratch {
  void operator()(uint8_t* memory) const;
};
using ScratchMemory = std::unique_ptr<uint8_t[], FreeScratch>;

// Takes `bytes` that are not zeroed, aligned for any type. A block of some megabytes asks for large pages,
// where the system has them: most of the first decode of a process would be spent on faults of small ones.
// Throws std::bad_alloc.
ScratchMemory take_scratch(size_t bytes);

// Asks for large pages for the part of a block that has room for them. The block must not have been touched.
void prefer_large_pages(void* memory, size_t bytes);

}  // namespace psplit
