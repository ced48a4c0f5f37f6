// The memory that a stream is decoded in: the sum of what each stage declares beside its allocations.
#pragma once

#include "src/core/border_walk.h"
#include "src/core/decode_patch.h"

namespace psplit::core {

// An encoder writes a few bits for each face: a stream with hundreds of faces a byte has false counts. No
// stream gets more memory than this. The limit also leaves room to double such a size in a size_t of 32 bits.
PSPLIT_HD inline uint64_t justified_bytes(uint64_t stream_bytes) {
  constexpr uint64_t kMost = ~size_t{0} / 2;
  const uint64_t bytes = (uint64_t{1} << 26) + 4096 * stream_bytes;
  return bytes < kMost ? bytes : kMost;
}

// The number of points that a stream is likely to have, if no directory says it: that of its vertices, and some
// more if there are seams.
PSPLIT_HD inline uint32_t likely_points(const StreamHeader& header) {
  const uint32_t points = header.counts.vertex_limit + header.point_count;
  return header.attribute_data_count > 0 ? points + points / 8 : points;
}
// The most points that it can have.
PSPLIT_HD inline uint64_t most_points(const StreamHeader& header) {
  if (!header.edgebreaker) return header.point_count;
  return header.attribute_data_count > 0 ? uint64_t{3} * header.counts.face_count : header.counts.vertex_limit;
}

// The memory that is enough to decode any stream of an encoder and to walk its border, if `values` is right. A
// stream that needs more has false counts, or other attributes than `values` says. A driver takes `after` bytes
// beside the walk, once the stream is decoded.
template <typename Index>
PSPLIT_HD size_t workspace_bytes(const StreamHeader& header, size_t stream_bytes, const ValueCounts& values,
                                 size_t after = 0) {
  using Attributes = AttributeDecoder<Index>;
  const uint32_t faces = header.counts.face_count;
  size_t mesh, connectivity, seams = 0;
  if (header.edgebreaker) {
    mesh = header.is_condensed() ? CondensedConnectivity<Index>::bytes(header.counts)
                                 : EdgebreakerDecoder<Index>::bytes(header);
    connectivity = header.is_condensed()
                       ? CondensedConnectivity<Index>::scratch_bytes(header.counts, header.condensed)
                       : EdgebreakerDecoder<Index>::scratch_bytes(header);
    if (header.valence) connectivity += RansTable::slot_bytes(header.counts.symbol_count, stream_bytes);
    if (header.attribute_data_count > 0) seams = SeamDecoder<Index>::bytes(header, values);
  } else {
    mesh = sequential_bytes<Index>(faces);
    connectivity = sequential_scratch_bytes(faces) + RansTable::slot_bytes(uint64_t{3} * faces, stream_bytes);
  }
  // Of two memories that are never taken at the same time, the larger one counts.
  const auto larger = [](size_t a, size_t b) { return a > b ? a : b; };
  // A stream with a border part is walked before its attributes are decoded, and that memory stays taken.
  const bool is_walked = header.is_condensed() && header.condensed.models.has_borders;
  const size_t walk = (is_walked ? 0 : border_walk_bytes<Index>(values.points)) + after;
  const size_t after_integers = larger(Attributes::scratch_bytes(header, values), walk);
  const size_t attributes = Attributes::bytes(header, values) +
                            Attributes::integer_bytes(header, stream_bytes, values) +
                            larger(Attributes::walk_bytes(header, values), after_integers);
  return mesh + larger(connectivity, seams + attributes);
}

}  // namespace psplit::core
