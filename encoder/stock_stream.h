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
  // What the stream decodes to: Draco drops faces that repeat a point, and unused points, and splits
  // non-manifold vertices.
  Mesh decoded;
  std::vector<uint32_t> source_point;  // for each decoded point the point of the mesh that it is
};

// by_libdraco: libdraco encodes it, and decodes it again, to the same bytes and meshes in more time. A mesh
// that Edgebreaker cannot encode becomes a sequential stream. choose_by_bytes: see EncodeOptions.
Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                          int encode_speed, bool by_libdraco = false,
                                          bool choose_by_bytes = false);
// The same as a sequential stream, which keeps all faces and points, and their order.
Expected<StockStream> encode_stock_sequential(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                              int encode_speed);

}  // namespace psplit
