// Memory to decode streams in. It is reused from one stream to the next.
#pragma once

#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "src/core/decode_patch.h"
#include "src/object_pool.h"
#include "src/scratch_memory.h"

namespace psplit {

// The index of streams whose numbers fit 16 bits (core::StreamHeader::fits_16_bits).
using NarrowIndex = std::conditional_t<PSPLIT_IS_SMALL_CODE, uint32_t, uint16_t>;

// Memory for one stream.
template <typename Index>
struct StreamMemory {
  ScratchMemory memory;
  size_t size = 0;
  core::StreamHeader header;  // the container's, and facts known before decoding
  core::Patch<Index> patch;
  std::optional<core::PatchDecoder<Index>> decoder;

  core::Arena arena(size_t at_least) {
    if (size < at_least) {
      memory.reset();  // before the new block is allocated: never hold both
      size = 0;        // also if that fails
      memory = take_scratch(at_least);
      size = at_least;
    }
    return {memory.get(), size};
  }
};

// All memory that one thread needs to decode: some hundred kilobytes at first.
struct Scratch {
  StreamMemory<NarrowIndex> streams[core::kInStep];  // one for each stream that a thread decodes in step
  core::Patch<uint32_t> wide;                        // decoded in the memory of the first
  std::vector<uint32_t> numbers;
};

// Scratches are kept when threads give them back, until release_scratch.
using ScratchPool = ObjectPool<Scratch>;

inline ScratchPool& scratch_pool() {
  static ScratchPool pool;
  return pool;
}

}  // namespace psplit
