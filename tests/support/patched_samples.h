// Containers for tests of decoders.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "encoder/encode_mesh.h"
#include "psplit/decode.h"

namespace psplit {

struct PatchedSample {
  std::string name;
  EncodedMesh encoded;
  std::vector<AttributeRequest> requests;  // all attributes, in the encoded types
  Mesh mesh;                               // what libdraco decodes
};

// A grid of `bits` for each attribute; normals are octahedral.
std::vector<AttributeCoding> fine_codings(const Mesh& mesh, int bits);

PatchedSample encode_sample(std::string name, const Mesh& mesh, std::span<const AttributeCoding> codings,
                            const StreamOptions& options, const ThreadPool& pool);

// A process makes each of these sets once, with the pool of its first caller.

// Every mesh of the catalogue in up to seven patches, both exact and on grids, with Draco's speeds in turn.
// Then long edges on fine grids, and morph targets, which share groups. All streams are Draco's.
const std::vector<PatchedSample>& patched_samples(const ThreadPool& pool);

// A container with its streams condensed, whether it gets smaller or not. `smallest` is that of condense. Empty
// if no stream can be condensed.
std::vector<uint8_t> condensed_container(const PatchContainer& container, bool smallest,
                                         const ThreadPool& pool);

// patched_samples with condensed streams, `smallest` in turn, except those without a stream that can be
// condensed. `original.encoded.pieces[0].bytes` is what each was made from.
struct CondensedSample {
  PatchedSample original;
  std::vector<uint8_t> container;
};
const std::vector<CondensedSample>& condensed_samples(const ThreadPool& pool);

// patched_samples, and then the containers of condensed_samples.
const std::vector<PatchedSample>& all_samples(const ThreadPool& pool);

// Grids at the limit of 16-bit indices, the larger one also condensed.
const std::vector<PatchedSample>& large_samples(const ThreadPool& pool);

}  // namespace psplit
