#include "encoder/draco/stock_stream.h"

#include <numeric>

#include "encoder/draco/draco_backend.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/welding/weld.h"

namespace psplit {

namespace {

// All of the mesh as a patch.
PatchMesh whole_mesh(const Mesh& mesh) {
  PatchMesh whole;
  whole.points.resize(mesh.point_count);
  std::iota(whole.points.begin(), whole.points.end(), 0u);
  whole.faces.assign(mesh.faces.begin(), mesh.faces.end());
  return whole;
}

Expected<StockStream> encode_in_order(const WeldedMesh& welded, PatchMesh whole,
                                      std::span<const AttributeCoding> codings, int encode_speed) {
  Expected<std::vector<uint8_t>> bytes = encode_sequential(welded, whole, codings, encode_speed);
  if (!bytes) return bytes.status();
  StockStream stock;
  stock.requests = stream_requests(*welded.mesh);
  stock.bytes = std::move(*bytes);
  Expected<Mesh> decoded = decode_draco_stream(stock.bytes, stock.requests);
  if (!decoded) return decoded.status();
  stock.decoded = std::move(*decoded);
  stock.source_point = std::move(whole.points);
  return stock;
}

}  // namespace

Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                          int encode_speed) {
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  PatchMesh whole = whole_mesh(mesh);
  Expected<EncodedPatch> encoded = encode_edgebreaker(welded, whole, codings, encode_speed, true);
  // Edgebreaker cannot encode a mesh with degenerate faces only.
  if (!encoded) return encode_in_order(welded, std::move(whole), codings, encode_speed);
  StockStream stock;
  stock.requests = stream_requests(mesh);
  stock.bytes = std::move(encoded->bytes);
  stock.decoded = std::move(encoded->decoded);
  stock.source_point = std::move(encoded->patch_point);  // the whole mesh is the patch
  return stock;
}

Expected<StockStream> encode_stock_sequential(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                              int encode_speed) {
  return encode_in_order(weld(mesh, ThreadPool(1)), whole_mesh(mesh), codings, encode_speed);
}

}  // namespace psplit
