#include "encoder/stock_stream.h"

#include "encoder/encode_patch.h"
#include "encoder/welding/weld.h"

namespace psplit {

namespace {

Expected<StockStream> keep_order(const WeldedMesh& welded, PatchMesh whole,
                                 std::span<const AttributeCoding> codings, int encode_speed, bool by_libdraco) {
  Expected<std::vector<uint8_t>> bytes = encode_in_order(welded, whole, codings, encode_speed, by_libdraco);
  if (!bytes) return bytes.status();
  StockStream stock;
  stock.requests = stream_requests(*welded.mesh);
  stock.bytes = std::move(*bytes);
  Expected<Mesh> decoded = decode_stream(*welded.mesh, stock.bytes);
  if (!decoded) return decoded.status();
  stock.decoded = std::move(*decoded);
  stock.source_point = std::move(whole.points);
  return stock;
}

}  // namespace

Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                          int encode_speed, bool by_libdraco) {
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  PatchMesh whole = whole_mesh(mesh);
  Expected<EncodedPatch> encoded = encode_patch(welded, whole, codings, encode_speed, by_libdraco, true);
  // Edgebreaker cannot encode a mesh with degenerate faces only. What is a fault of ours is said.
  if (!encoded && !by_libdraco && encoded.status().code() == StatusCode::kRuntimeFailure)
    return encoded.status();
  if (!encoded) return keep_order(welded, std::move(whole), codings, encode_speed, by_libdraco);
  StockStream stock;
  stock.requests = stream_requests(mesh);
  stock.bytes = std::move(encoded->bytes);
  stock.decoded = std::move(encoded->decoded);
  stock.source_point = std::move(encoded->patch_point);  // the whole mesh is the patch
  return stock;
}

Expected<StockStream> encode_stock_sequential(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                              int encode_speed, bool by_libdraco) {
  return keep_order(weld(mesh, ThreadPool(1)), whole_mesh(mesh), codings, encode_speed, by_libdraco);
}

}  // namespace psplit
