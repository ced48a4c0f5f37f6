// Encodes one patch, or a whole mesh, as one Draco stream: by our encoder, or by libdraco's for reference.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/encode_mesh.h"
#include "encoder/libdraco/patch_stream.h"
#include "encoder/stream/encode_stream.h"
#include "encoder/stream/sequential_stream.h"
#include "encoder/stream/smallest_stream.h"
#include "encoder/stream/stream_steps.h"
#include "encoder/welding/weld.h"
#include "psplit/base.h"
#include "psplit/encode.h"

namespace psplit {

// What the options say about one stream: encode_speed, by_libdraco and choose_by_bytes.

// Edgebreaker streams.
inline Expected<EncodedPatch> encode_patch(const WeldedMesh& welded, const PatchMesh& patch,
                                           std::span<const AttributeCoding> codings,
                                           const StreamOptions& options, bool with_values) {
  if (options.by_libdraco) {
    Expected<EncodedPatch> encoded =
        encode_edgebreaker(welded, patch, codings, options.encode_speed, with_values);
    // libdraco does not say what its tables take.
    if (encoded && options.most_split_percent > 0) encoded->table_bytes = table_bytes_of(encoded->bytes);
    return encoded;
  }
  if (options.choose_by_bytes)
    return encode_smallest_stream(welded, patch, codings, with_values, options.in_creation_order);
  return encode_stream(welded, patch, codings, options.encode_speed, with_values);
}

// Sequential streams. Their only prediction is the difference, so bytes have no choice.
inline Expected<std::vector<uint8_t>> encode_in_order(const WeldedMesh& welded, const PatchMesh& patch,
                                                      std::span<const AttributeCoding> codings,
                                                      const StreamOptions& options) {
  if (options.by_libdraco) return encode_sequential(welded, patch, codings, options.encode_speed);
  return write_sequential_stream({welded, codings, patch.points_of_values()}, patch.faces,
                                 options.encode_speed);
}

}  // namespace psplit
