// Encodes one patch, or a whole mesh, as one Draco stream: by our encoder, or by libdraco's for reference.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/stream/sequential_stream.h"
#include "encoder/welding/weld.h"
#include "src/status.h"

namespace psplit {

// Edgebreaker streams.
inline Expected<EncodedPatch> encode_patch(const WeldedMesh& welded, const PatchMesh& patch,
                                           std::span<const AttributeCoding> codings, int encode_speed,
                                           bool by_libdraco, bool with_values) {
  return (by_libdraco ? encode_edgebreaker : encode_stream)(welded, patch, codings, encode_speed, with_values);
}

// Sequential streams.
inline Expected<std::vector<uint8_t>> encode_in_order(const WeldedMesh& welded, const PatchMesh& patch,
                                                      std::span<const AttributeCoding> codings,
                                                      int encode_speed, bool by_libdraco) {
  if (by_libdraco) return encode_sequential(welded, patch, codings, encode_speed);
  return write_sequential_stream({welded, codings, patch.points_of_values()}, patch.faces, encode_speed);
}

}  // namespace psplit
