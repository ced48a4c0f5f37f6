// The decoder for CPUs: the core on a pool of threads. The default backend. It does not need libdraco.
#pragma once

#include "src/container/decode_backend.h"

namespace psplit {

// Decodes containers patch by patch on all threads of the pool, and stock Draco 2.2 mesh streams on one thread
// each. Results equal libdraco's to the bit. Any bytes may be given. Errors: kUnsupported for streams of older
// bitstreams, kInvalidInput for everything else that cannot be decoded, with the patch as its place. Checks
// before each patch whether to stop, and reports progress after each. Thread-safe.
PSPLIT_EXPORT DecodeBackend cpu_backend();

// Frees the memory that threads keep from one call to the next: for each thread that decoded at the same time,
// as much as its largest streams took. Threads that are decoding keep theirs. Thread-safe.
PSPLIT_EXPORT void release_scratch();

}  // namespace psplit
