// Encodes one patch, or a whole mesh, as one Draco stream.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "src/container/decode_backend.h"
#include "src/status.h"

namespace psplit {

// How to request each attribute of the mesh, in order, from a decoder of any stream that these functions write.
// Draco's unique id of POSITION is 0; those of the others follow in their order.
std::vector<AttributeRequest> stream_requests(const Mesh& mesh);

// No face may use a vertex twice.
Expected<EncodedPatch> encode_edgebreaker(const WeldedMesh& welded, const PatchMesh& patch,
                                          std::span<const AttributeCoding> codings, int encode_speed,
                                          bool with_values = false);
// A sequential stream. It keeps the order of points and faces, and takes any face. Indices are compressed if
// that makes the stream smaller.
Expected<std::vector<uint8_t>> encode_sequential(const WeldedMesh& welded, const PatchMesh& patch,
                                                 std::span<const AttributeCoding> codings, int encode_speed);

}  // namespace psplit
