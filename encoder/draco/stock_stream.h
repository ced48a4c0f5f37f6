// Encodes a whole mesh as one stock Draco stream, as KHR_draco_mesh_compression stores it. psplit is measured
// against these streams.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "src/container/decode_backend.h"
#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

struct StockStream {
  std::vector<uint8_t> bytes;
  std::vector<AttributeRequest> requests;  // one for each attribute of the mesh, in order
  // The counts that a decoder of the stream returns: Draco drops faces that repeat a point, and unused points,
  // and splits non-manifold vertices.
  uint32_t face_count = 0;
  uint32_t point_count = 0;
  // For each decoded point the point of the mesh that it is, if the caller asked for it.
  std::vector<uint32_t> source_point;
};

Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                          int encode_speed, bool with_source_points = false);

}  // namespace psplit
