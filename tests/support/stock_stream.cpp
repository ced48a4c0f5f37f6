#include "tests/support/stock_stream.h"

#include "encoder/libdraco/patch_stream.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/stream/sequential_stream.h"
#include "encoder/stream/smallest_stream.h"
#include "encoder/welding/weld.h"

namespace psplit {

Expected<StockStream> encode_stock_sequential(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                              int speed) {
  PatchMesh whole = whole_mesh(mesh);
  const WeldedMesh welded = weld(mesh, ThreadPool(1));
  Expected<std::vector<uint8_t>> bytes =
      write_sequential_stream({welded, codings, whole.points}, whole.faces, speed);
  if (!bytes) return bytes.status();
  Expected<Mesh> decoded = decode_stream(mesh, *bytes);
  if (!decoded) return decoded.status();
  return StockStream{std::move(*bytes), stream_requests(mesh), std::move(*decoded), std::move(whole.points)};
}

Expected<StockStream> encode_stock_stream(const Mesh& mesh, std::span<const AttributeCoding> codings, int speed,
                                          bool by_libdraco, bool choose_by_bytes) {
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  const PatchMesh whole = whole_mesh(mesh);
  Expected<EncodedPatch> encoded = by_libdraco       ? encode_edgebreaker(welded, whole, codings, speed, true)
                                   : choose_by_bytes ? encode_smallest_stream(welded, whole, codings, true)
                                                     : encode_stream(welded, whole, codings, speed, true);
  if (!encoded && !by_libdraco && encoded.status().code() != StatusCode::kRuntimeFailure)
    return encode_stock_sequential(mesh, codings, speed);
  if (!encoded) return encoded.status();
  return StockStream{std::move(encoded->bytes), stream_requests(mesh), std::move(encoded->decoded),
                     std::move(encoded->patch_point)};
}

}  // namespace psplit
