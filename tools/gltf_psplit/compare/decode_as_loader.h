// Decoding the meshes of an asset as a loader decodes them. `compare` and the benchmarks time this.
#pragma once

#include <cstdint>
#include <span>

#include "psplit/decode.h"
#include "psplit/encode.h"
#include "psplit/parallel.h"

namespace psplit {

struct DecodedCounts {
  uint64_t faces = 0, points = 0;  // of all meshes together
};

// Opens the only piece of each mesh, a container or a stock Draco stream, and decodes all of them in one call
// of the backend, as psplit/loader.h does with the primitives of an asset: cpu_backend then decodes short
// streams in step. Memory for the results is allocated each time. Returns the first error.
Expected<DecodedCounts> decode_as_loader(std::span<const EncodedMesh> meshes, const DecodeBackend& backend,
                                         const ThreadPool& pool);

}  // namespace psplit
