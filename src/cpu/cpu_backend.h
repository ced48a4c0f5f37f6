// The decoder for CPUs: the core on a pool of threads. The default backend. It does not need libdraco.
#pragma once

#include "src/container/decode_backend.h"
#include "src/container/stream_description.h"

namespace psplit {

// Decodes containers patch by patch on all threads of the pool, and stock Draco 2.2 mesh streams on one thread
// each. Results equal libdraco's to the bit. Any bytes may be given. Errors: kUnsupported for streams of older
// bitstreams, kInvalidInput for everything else that cannot be decoded, with the patch as its place. Checks
// before each patch whether to stop, and reports progress after each. Thread-safe.
PSPLIT_EXPORT DecodeBackend cpu_backend();

// Frees the memory that threads keep from one call to the next: for each thread that decoded at the same time,
// as much as its largest streams took. Threads that are decoding keep theirs. Thread-safe.
PSPLIT_EXPORT void release_scratch();

// Describes a Draco 2.2 mesh stream. It decodes the stream for that, on the calling thread. Any bytes may be
// given. Errors are those of the backend. Thread-safe.
PSPLIT_EXPORT Expected<StreamDescription> describe_stream(std::span<const uint8_t> stream);

// Decodes a .drc file, or any other Draco 2.2 mesh stream, with all its attributes. gltf_attributes
// (src/container/stream_description.h) chooses their names and types. Decodes once, on the calling thread. If
// the attributes are known, or there are many streams, src/loader/loader.h is faster. Takes at most 64 MiB and
// 4096 bytes for each byte of the stream, twice. Any bytes may be given. Errors are those of describe_stream
// and gltf_attributes. Thread-safe.
PSPLIT_EXPORT Expected<Mesh> decode_draco(std::span<const uint8_t> stream);

}  // namespace psplit
