#include "encoder/stock_stream.h"

#include "encoder/encode_patch.h"
#include "encoder/welding/weld.h"

namespace psplit {

namespace {

EncodeOptions stream_options(int encode_speed, bool by_libdraco, bool choose_by_bytes) {
  EncodeOptions options;
  options.encode_speed = encode_speed;
  options.by_libdraco = by_libdraco;
  options.choose_by_bytes = choose_by_bytes;
  return options;
}

Expected<StockStream> keep_order(const WeldedMesh& welded, PatchMesh whole,
                                 std::span<const AttributeCoding> codings, const EncodeOptions& options) {
  Expected<std::vector<uint8_t>> bytes = encode_in_order(welded, whole, codings, options);
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
                                          int encode_speed, bool by_libdraco, bool choose_by_bytes) {
  const EncodeOptions options = stream_options(encode_speed, by_libdraco, choose_by_bytes);
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  PatchMesh whole = whole_mesh(mesh);
  Expected<EncodedPatch> encoded = encode_patch(welded, whole, codings, options, true);
  // Edgebreaker cannot encode a mesh with degenerate faces only. What is a fault of ours is said.
  if (!encoded && !by_libdraco && encoded.status().code() == StatusCode::kRuntimeFailure)
    return encoded.status();
  if (!encoded) return keep_order(welded, std::move(whole), codings, options);
  StockStream stock;
  stock.requests = stream_requests(mesh);
  stock.bytes = std::move(encoded->bytes);
  stock.decoded = std::move(encoded->decoded);
  stock.source_point = std::move(encoded->patch_point);  // the whole mesh is the patch
  return stock;
}

Expected<StockStream> encode_stock_sequential(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                              int encode_speed) {
  return keep_order(weld(mesh, ThreadPool(1)), whole_mesh(mesh), codings,
                    stream_options(encode_speed, /*by_libdraco=*/false, /*choose_by_bytes=*/false));
}

}  // namespace psplit
