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

// Describes a Draco stream: a mesh of bitstream 2.2, or a point cloud of 2.2 or 2.3. It decodes the stream for
// that, on the calling thread. Any bytes may be given. Errors are those of the backend. Thread-safe.
PSPLIT_EXPORT Expected<StreamDescription> describe_stream(std::span<const uint8_t> stream);

// Decodes a .drc file, or any other Draco stream that describe_stream describes, with all its attributes. A
// point cloud becomes a mesh without faces. gltf_attributes (src/container/stream_description.h) chooses names
// and types. `description`, if it is not null, becomes that of the stream. Decodes once, on the calling thread.
// If the attributes are known, or there are many streams, src/loader/loader.h is faster. Takes at most 64 MiB
// and 4096 bytes for each byte of the stream, twice. Any bytes may be given. Errors are those of
// describe_stream and gltf_attributes. Thread-safe.
PSPLIT_EXPORT Expected<Mesh> decode_draco(std::span<const uint8_t> stream,
                                          StreamDescription* description = nullptr);

// One value for each point, tightly packed, in the type that the stream has: description.components of
// description.type, little-endian.
struct CloudAttribute {
  StreamAttribute description;
  Array<std::byte> values;

  explicit CloudAttribute(StreamAttribute of) : description(std::move(of)) {}
};
struct PointCloud {
  StreamCoding coding = StreamCoding::kCloudSequential;
  uint32_t point_count = 0;
  std::vector<CloudAttribute> attributes;  // in the order of the stream
};

// Decodes a point cloud to its own types, without the names and limits of glTF. The order of points is that of
// the stream. Memory, thread and errors are those of decode_draco; kInvalidInput for a mesh, too. Thread-safe.
PSPLIT_EXPORT Expected<PointCloud> decode_cloud(std::span<const uint8_t> stream);

}  // namespace psplit
