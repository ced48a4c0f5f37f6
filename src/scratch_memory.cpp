#include "src/scratch_memory.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <new>

namespace psplit {

void FreeScratch::operator()(uint8_t* memory) const { ::operator delete(memory); }

ScratchMemory take_scratch(size_t bytes) {
  ScratchMemory memory(static_cast<uint8_t*>(::operator new(bytes)));
  prefer_large_pages(memory.get(), bytes);
  return memory;
}

void prefer_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] size_t bytes) {
#if defined(__linux__)
  constexpr uintptr_t kLargePage = uintptr_t{1} << 21;
  const auto begin = reinterpret_cast<uintptr_t>(memory);
  const uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage,
                  end = (begin + bytes) / kLargePage * kLargePage;
  if (first < end) ::madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
}

}  // namespace psplit
