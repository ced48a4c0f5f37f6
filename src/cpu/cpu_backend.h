// The CPU driver: the core's decoder on a pool of threads. The default backend; it needs no libdraco.
#pragma once

#include "src/container/decode_backend.h"
#include "src/container/stream_description.h"

namespace psplit {

// Decodes containers patch by patch on all threads of the pool, and Draco 2.2 mesh streams on the caller's
// thread. Results are libdraco's to the bit. Any bytes may be given. Streams of older versions are
// kUnsupported, all else that cannot be decoded is kInvalidInput, with the patch as its place. decode_into
// looks before every patch whether to stop, and tells after each. Safe to call from many threads.
PSPLIT_EXPORT DecodeBackend cpu_backend();

// What a Draco 2.2 mesh stream is: it is decoded for that, on the caller's thread. Any bytes may be given, and
// errors are those of the backend. Safe to call from many threads.
PSPLIT_EXPORT Expected<StreamDescription> describe_stream(std::span<const uint8_t> stream);

// A .drc file, or any other Draco 2.2 mesh stream, with all attributes that it has, as gltf_attributes
// (src/container/stream_description.h) names and types them: for those who know nothing else of it. Decodes
// once, on the caller's thread; who knows the attributes, or has many streams, decodes faster with
// src/loader/loader.h. Takes no more than 64 MiB and 4096 bytes for each byte of the stream, twice. Any bytes
// may be given; errors are those of describe_stream and gltf_attributes. Safe to call from many threads.
PSPLIT_EXPORT Expected<Mesh> decode_draco(std::span<const uint8_t> stream);

}  // namespace psplit
