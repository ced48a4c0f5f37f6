// Encodes a mesh as a sequence of parts: one after the other, into one container. A mesh that is in memory is
// one part (encode_mesh); one that does not fit into memory is cut into several. The container has the patches
// of the first part, then of the second, and so on. The stitch map refers to patches of earlier parts as it
// does within a part, so the container decodes to one mesh, without cracks and without a point twice.
//
// Memory: what encode_mesh takes for the largest part, its streams included; a little for each point that parts
// share, each patch and the residue of a container (gltf_ext/convert/memory_model.h has the numbers); and with
// streams.condense a container, what condense takes for it, and to verify it twice what it decodes to.
// Streams, stitch maps and border walks are in spills: about the container's size, and 4 bytes for each point
// at the border of a patch.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "encoder/encode_mesh.h"
#include "encoder/encode_streams.h"
#include "encoder/mesh_parts.h"
#include "encoder/partition/partition.h"
#include "encoder/spill.h"
#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

struct PartsOptions {
  uint64_t patch_faces = 30000;  // a part of F faces gets round(F / patch_faces) patches, at least 1
  // Options of the streams of all parts. Each part decides itself which points are merged and which faces are
  // dropped. With Alone::kAll there are no containers, because each stream is alone; otherwise no stream is.
  // Only a whole mesh takes patch_count and patch_of_face.
  StreamOptions streams{};
  // The most points of a container. The part that would exceed it begins another container.
  uint64_t most_points = 0xfffffffe;
  // Faces that repeat an index, and points that no face uses, are in memory until their container ends: with
  // more of these points, it ends early.
  uint64_t most_residue_points = 0xfffffffe;
  // A container is in memory while it is condensed: with this many points, it ends.
  uint64_t condensed_points = 0xfffffffe;
  // Called after each part with the bytes of all streams and stitch maps so far. An error ends the work.
  std::function<Status(uint64_t)> part_written{};
};

// `codings` has one entry per attribute. Each part is decoded from the bytes that were written, for the bounds
// and to verify it. The result is byte-identical for any number of threads, and the container of a single part
// is that of encode_mesh with the same number of patches. Errors: as for encode_mesh, `parts` and the
// spills, with the part in the message and the patch as their place; kUnsupported if a part alone exceeds the
// limits of a container.
Expected<EncodedMesh> encode_parts(MeshParts& parts, Span<const AttributeCoding> codings,
                                   const PartsOptions& options, const MakeSpill& make_spill,
                                   const ThreadPool& pool);

// Stores the streams of a mesh that is in memory, as the only part: what encode_mesh does with the streams of a
// reduced mesh. With Alone::kWhole its only stream is alone.
Expected<EncodedMesh> store_whole(const Mesh& mesh, Span<const AttributeCoding> codings,
                                  const StreamOptions& options, Streams streams, const ThreadPool& pool);

}  // namespace psplit
