// Containers to test decoders on.
#pragma once

#include <string>
#include <vector>

#include "encoder/encode_mesh.h"
#include "src/container/decode_backend.h"

namespace psplit {

struct PatchedSample {
  std::string name;
  EncodedMesh encoded;
  std::vector<AttributeRequest> requests;  // all attributes, in the types that were encoded
};

// Every mesh of the catalogue in up to seven patches, exactly and on grids, at all of Draco's speeds in turn;
// then containers of version 1, of which nothing but the bytes is known.
std::vector<PatchedSample> patched_samples(const ThreadPool& pool);

bool same_bits(const Mesh& a, const Mesh& b);

}  // namespace psplit
