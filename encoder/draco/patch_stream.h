// Encodes one patch, or a whole mesh, as one Draco stream.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/welding/weld.h"
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

// An Edgebreaker stream, and what libdraco decodes it to.
struct EncodedPatch {
  std::vector<uint8_t> bytes;
  // In the order of the stream. Its attributes are there only if the caller wants their values.
  Mesh decoded;
  // For each decoded point the patch's point. A point occurs more than once if Edgebreaker has to split it.
  std::vector<uint32_t> patch_point;
};

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

// Whether libdraco's encoder would predict texture coordinates from positions with products that may exceed 64
// bits. It then fails, or writes a stream that newer versions of its decoder refuse. That needs grids of many
// bits, and edges about as long as the grid of positions. `texcoords` is the index of an attribute of the mesh
// that has two components.
bool texture_prediction_may_overflow(const WeldedMesh& welded, const PatchMesh& patch,
                                     std::span<const AttributeCoding> codings, size_t texcoords,
                                     int encode_speed);

// About the memory that libdraco's encoder takes to count the symbols of an attribute: it has an entry for
// every number up to the largest symbol. At speeds 0 and 1, which compare predictions, it takes eight times as
// much (measured: 7.5). 0 if no grid has enough bits for more than 64 MB.
uint64_t symbol_table_bytes(const WeldedMesh& welded, const PatchMesh& patch,
                            std::span<const AttributeCoding> codings, int encode_speed);

}  // namespace psplit
