#include "src/cpu/scratch_memory.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <new>

namespace psplit {

void FreeScratch::operator()(uint8_t* memory) const { ::operator delete(memory); }

ScratchMemory take_scratch(size_t bytes) {
  ScratchMemory memory(static_cast<uint8_t*>(::operator new(bytes)));
#if defined(__linux__)
  constexpr size_t kHugePage = size_t{1} << 21;
  const auto begin = reinterpret_cast<uintptr_t>(memory.get());
  const uintptr_t first = (begin + kHugePage - 1) / kHugePage * kHugePage,
                  end = (begin + bytes) / kHugePage * kHugePage;
  if (first < end) ::madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
  return memory;
}

}  // namespace psplit
