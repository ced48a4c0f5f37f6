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
// Then long edges on fine grids. All streams are Draco's. A process makes them once.
std::vector<PatchedSample> patched_samples(const ThreadPool& pool);

// A container with its streams condensed, whether it gets smaller or not. `smallest` is that of condense. Empty
// if no stream can be condensed.
std::vector<uint8_t> condensed_container(const PatchContainer& container, bool smallest,
                                         const ThreadPool& pool);

// patched_samples with condensed streams, `smallest` in turn, except those without a stream that can be
// condensed. `original.encoded.container` is what each was made from.
struct CondensedSample {
  PatchedSample original;
  std::vector<uint8_t> container;
};
std::vector<CondensedSample> condensed_samples(const ThreadPool& pool);

// patched_samples, and then the containers of condensed_samples. A process makes them once.
std::vector<PatchedSample> all_samples(const ThreadPool& pool);

bool same_bits(const Mesh& a, const Mesh& b);

}  // namespace psplit
