#include "encoder/draco/stock_stream.h"

#include <numeric>

#include "encoder/draco/draco_backend.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/welding/weld.h"

namespace psplit {

Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                          int encode_speed, bool with_source_points) {
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  PatchMesh whole;
  whole.points.resize(mesh.point_count);
  std::iota(whole.points.begin(), whole.points.end(), 0u);
  whole.faces.assign(mesh.faces.begin(), mesh.faces.end());

  StockStream stock;
  stock.requests = stream_requests(mesh);
  Expected<std::vector<uint8_t>> bytes = encode_edgebreaker(welded, whole, codings, encode_speed);
  // Edgebreaker cannot encode a mesh with degenerate faces only.
  const bool is_sequential = !bytes.ok();
  if (is_sequential) bytes = encode_sequential(welded, whole, codings, encode_speed);
  if (!bytes) return bytes.status();
  stock.bytes = std::move(*bytes);
  Expected<StreamCounts> counts = stream_counts(stock.bytes);
  if (!counts) return counts.status();
  stock.face_count = counts->face_count;
  stock.point_count = counts->point_count;
  if (!with_source_points) return stock;
  if (is_sequential) {
    stock.source_point = std::move(whole.points);
    return stock;
  }
  Expected<DecodedOrder> order = edgebreaker_order(welded, whole, encode_speed);
  if (!order) return order.status();
  stock.source_point = std::move(order->patch_point);  // the whole mesh is the patch
  return stock;
}

}  // namespace psplit
