// How large compressed primitives are, as the JSON of their document states it: no stream is opened.
#pragma once

#include <cstdint>

#include "gltf_ext/document/document.h"
#include "psplit/document.h"

namespace psplit {

struct StatedBytes {
  uint64_t stored = 0;   // of the container, or of the stream of stock Draco
  uint64_t decoded = 0;  // of the buffer views that decoding makes of it

  // Whether decoding in memory stays within the limit. It takes the stored bytes, the decoded bytes, and in
  // addition the bytes decoded from stock Draco, or the copies of points at the borders of patches.
  bool fit_into(const MemoryLimit& limit) const { return limit.allows(stored + 2 * decoded); }
};

// Zeros if the primitive is plain, or if its stored bytes do not justify the counts of its accessors, an error
// that decoding finds.
StatedBytes stated_bytes(const Document& document, PrimitiveId id);

// The sum. Equal primitives, which share the decoded data, count once.
StatedBytes stated_bytes(const Document& document);

}  // namespace psplit
