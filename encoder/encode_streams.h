// The streams of a mesh's patches. Encoding a mesh in memory and encoding it part by part share them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/cut_faces.h"
#include "encoder/encode_mesh.h"
#include "encoder/stitching/build_stitching.h"
#include "src/container/stream_entry.h"

namespace psplit {

// Everything that goes into a container.
struct Streams {
  std::vector<OwnedStream> owned;
  std::vector<std::vector<uint8_t>> bytes;
  bool has_residue = false;
};

// Whether encode_mesh can encode the mesh with these codings. Errors: kInvalidInput, kUnsupported.
Status check_mesh(const Mesh& mesh, std::span<const AttributeCoding> codings);

// Encodes all patches, without the residue. Errors have the number of the patch as their place.
Status encode_patches(const WeldedMesh& welded, const Cut& cut, std::span<const AttributeCoding> codings,
                      const EncodeOptions& options, const ThreadPool& pool, Streams& streams);

// The rows of the directory. Errors: kUnsupported.
Expected<std::vector<StreamEntry>> make_entries(const Streams& streams, const Stitching& stitching);

}  // namespace psplit
