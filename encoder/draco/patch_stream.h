// Encodes one patch, or a whole mesh, as one Draco stream.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/welding/welded_mesh.h"
#include "src/container/decode_backend.h"
#include "src/status.h"

namespace psplit {

// A part of a welded mesh. Its points have numbers of their own, from 0.
struct PatchMesh {
  std::vector<uint32_t> points;                // points of the mesh
  std::vector<std::array<uint32_t, 3>> faces;  // indices into `points`
  // If not empty, the points of the mesh whose values are stored for those of `points`.
  std::vector<uint32_t> value_points;

  const std::vector<uint32_t>& points_of_values() const { return value_points.empty() ? points : value_points; }
};

// The faces and points that a decoder of the patch's stream returns. `patch_point` has the patch's point for
// each decoded point. A point occurs more than once if Edgebreaker has to split it.
struct DecodedOrder {
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<uint32_t> patch_point;
};

// How to request each attribute of the mesh, in order, from a decoder of any stream that these functions write.
// Draco's unique id of POSITION is 0; those of the others follow in their order.
std::vector<AttributeRequest> stream_requests(const Mesh& mesh);

// An Edgebreaker stream. No face may use a vertex twice.
Expected<std::vector<uint8_t>> encode_edgebreaker(const WeldedMesh& welded, const PatchMesh& patch,
                                                  std::span<const AttributeCoding> codings, int encode_speed);
// A sequential stream. It keeps the order of points and faces, and takes any face. Indices are compressed if
// that makes the stream smaller.
Expected<std::vector<uint8_t>> encode_sequential(const WeldedMesh& welded, const PatchMesh& patch,
                                                 std::span<const AttributeCoding> codings, int encode_speed);

// The order of points and faces in the stream that encode_edgebreaker writes for the same arguments.
Expected<DecodedOrder> edgebreaker_order(const WeldedMesh& welded, const PatchMesh& patch, int encode_speed);

}  // namespace psplit
