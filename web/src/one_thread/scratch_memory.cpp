// Scratch of a module, whose memory has no pages to choose.
#include "src/cpu/scratch_memory.h"

namespace psplit {

void FreeScratch::operator()(uint8_t* memory) const { ::operator delete(memory); }

ScratchMemory take_scratch(size_t bytes) { return ScratchMemory(static_cast<uint8_t*>(::operator new(bytes))); }

}  // namespace psplit
