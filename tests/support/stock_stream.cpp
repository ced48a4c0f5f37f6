#include "tests/support/stock_stream.h"

#include "encoder/encode_mesh.h"
#include "encoder/encode_patch.h"
#include "encoder/welding/weld.h"

namespace psplit {

Expected<StockStream> encode_stock_sequential(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                              int speed) {
  StreamOptions options;
  options.encode_speed = speed;
  PatchMesh whole = whole_mesh(mesh);
  Expected<std::vector<uint8_t>> bytes = encode_in_order(weld(mesh, ThreadPool(1)), whole, codings, options);
  if (!bytes) return bytes.status();
  Expected<Mesh> decoded = decode_stream(mesh, *bytes);
  if (!decoded) return decoded.status();
  return StockStream{std::move(*bytes), stream_requests(mesh), std::move(*decoded), std::move(whole.points)};
}

Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings, int speed,
                                          bool by_libdraco, bool choose_by_bytes) {
  StreamOptions options;
  options.encode_speed = speed;
  options.by_libdraco = by_libdraco;
  options.choose_by_bytes = choose_by_bytes;
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  Expected<EncodedPatch> encoded = encode_patch(welded, whole_mesh(mesh), codings, options, true);
  if (!encoded && !by_libdraco && encoded.status().code() != StatusCode::kRuntimeFailure)
    return encode_stock_sequential(mesh, codings, speed);
  if (!encoded) return encoded.status();
  return StockStream{std::move(encoded->bytes), stream_requests(mesh), std::move(encoded->decoded),
                     std::move(encoded->patch_point)};
}

}  // namespace psplit
