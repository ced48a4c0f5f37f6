// Encodes one patch, or a whole mesh, as one Draco stream.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/stream/sequential_stream.h"
#include "encoder/welding/weld.h"
#include "src/container/decode_backend.h"
#include "src/status.h"

namespace psplit {

// What encode_stream does, by libdraco's encoder and decoder.
Expected<EncodedPatch> encode_edgebreaker(const WeldedMesh& welded, const PatchMesh& patch,
                                          std::span<const AttributeCoding> codings, int encode_speed,
                                          bool with_values = false);
// What write_sequential_stream does, by libdraco's encoder.
Expected<std::vector<uint8_t>> encode_sequential(const WeldedMesh& welded, const PatchMesh& patch,
                                                 std::span<const AttributeCoding> codings, int encode_speed);

// Edgebreaker and sequential streams by either encoder.
inline Expected<EncodedPatch> encode_patch(const WeldedMesh& welded, const PatchMesh& patch,
                                           std::span<const AttributeCoding> codings, int encode_speed,
                                           bool by_libdraco, bool with_values) {
  return (by_libdraco ? encode_edgebreaker : encode_stream)(welded, patch, codings, encode_speed, with_values);
}
inline Expected<std::vector<uint8_t>> encode_in_order(const WeldedMesh& welded, const PatchMesh& patch,
                                                      std::span<const AttributeCoding> codings,
                                                      int encode_speed, bool by_libdraco) {
  if (by_libdraco) return encode_sequential(welded, patch, codings, encode_speed);
  return write_sequential_stream({welded, codings, patch.points_of_values()}, patch.faces, encode_speed);
}

}  // namespace psplit
