// Containers for tests of decoders.
#pragma once

#include <string>
#include <vector>

#include "encoder/encode_mesh.h"
#include "src/container/decode_backend.h"

namespace psplit {

struct PatchedSample {
  std::string name;
  EncodedMesh encoded;
  std::vector<AttributeRequest> requests;  // all attributes, in the encoded types
};

// A grid of `bits` for each attribute; normals are octahedral.
std::vector<AttributeCoding> fine_codings(const Mesh& mesh, int bits);

// Every mesh of the catalogue in up to seven patches, both exact and on grids, with Draco's speeds in turn.
// Then long edges on fine grids, and containers of version 1, which exist only as bytes. All streams are
// Draco's. A process makes them once.
std::vector<PatchedSample> patched_samples(const ThreadPool& pool);

// The same, and the meshes that become smaller with condensed streams. A process makes them once.
std::vector<PatchedSample> all_samples(const ThreadPool& pool);

bool same_bits(const Mesh& a, const Mesh& b);

}  // namespace psplit
