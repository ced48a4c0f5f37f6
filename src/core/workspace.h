// How much memory a stream decodes in.
#pragma once

#include "src/core/border_walk.h"

namespace psplit::core {

// What a directory says of a stream beside the stream's own header.
struct ValueCounts {
  uint32_t points = 0;
  uint32_t attributes = 0;
  uint32_t components = 0;  // of all attributes together
};

// Streams of a few bits a face are honest; of hundreds of faces a byte they are not. No stream gets more memory
// than this, whatever it claims.
PSPLIT_HD inline uint64_t justified_bytes(uint64_t stream_bytes) {
  return (uint64_t{1} << 26) + 4096 * stream_bytes;
}

// How many points a stream is likely to have where no directory says: as many as vertices, and some for seams.
PSPLIT_HD inline uint32_t likely_points(const StreamHeader& header) {
  const uint32_t points = header.counts.vertex_limit + header.point_count;
  return header.attribute_data_count > 0 ? points + points / 8 : points;
}
// More it does not have.
PSPLIT_HD inline uint64_t most_points(const StreamHeader& header) {
  if (!header.edgebreaker) return header.point_count;
  return header.attribute_data_count > 0 ? uint64_t{3} * header.counts.face_count : header.counts.vertex_limit;
}

// Memory that every stream decodes in which an encoder wrote and for which `values` is true, and in which its
// border is walked. A stream that needs more lies about its counts, or about its attributes.
template <typename Index>
PSPLIT_HD size_t workspace_bytes(const StreamHeader& header, size_t stream_bytes, const ValueCounts& values) {
  size_t kept = 0;
  const auto array = []<typename T>(T, uint64_t count) { return static_cast<size_t>(count) * sizeof(T) + 15; };
  const uint64_t faces = header.counts.face_count, points = values.points, attributes = values.attributes;
  const uint64_t corners = 4 * faces, vertices = uint64_t{header.counts.vertex_limit} + 3;
  const uint64_t symbols = header.counts.symbol_count, seamed = header.attribute_data_count;
  const uint64_t groups = !header.edgebreaker || attributes < seamed + 1 ? attributes : seamed + 1;
  // A slot for each symbol that occurs; each has a byte in the stream.
  const uint64_t most_symbols = points * values.components + 3 * faces;
  const size_t slots = array(RansTable::Slot(), most_symbols < stream_bytes ? most_symbols : stream_bytes);
  const size_t tables = array(uint64_t{}, uint64_t{1} << RansTable::kDirectBits);
  const size_t mark = array(bool{}, faces < 0x4000 && sizeof(Index) == 2 ? 0x4000 : faces + 1);
  const auto larger = [](size_t a, size_t b) { return a > b ? a : b; };

  size_t connectivity = 0, reading = 0, predicting = 0;
  if (header.edgebreaker) {
    kept += 2 * array(Index{}, corners) + array(BorderEdge<Index>(), vertices) + array(bool{}, vertices) +
            array(Index{}, symbols);
    connectivity = array(SplitEvent(), header.counts.split_count) + 2 * array(Index{}, symbols);
    if (header.valence)
      connectivity += array(Index{}, vertices) + array(uint32_t{}, symbols) +
                      ValenceSymbols<Index>::kLists * (array(SymbolSequence(), 1) + tables);
    if (seamed > 0) {
      kept += array(AttributeTable<Index>(), seamed) + array(BitSteps(), seamed) + array(Index{}, 3 * faces) +
              array(uint8_t{}, seamed * (3 * faces / 2)) + 2 * array(bool{}, vertices) +
              array(Index{}, vertices);
      kept += seamed * (2 * array(Index{}, corners) + array(bool{}, 3 * faces));
      kept += array(Index{}, corners) + array(Index{}, points);
    }
    // Depth first, or by prediction degree and for the time being.
    kept += groups * (array(Index{}, points + 1) + array(Index{}, points) + mark + array(Index{}, faces + 1));
    reading = array(bool{}, points) + 3 * array(Index{}, 2 * faces + 1);
  } else {
    kept += array(Index{}, corners) + array(Index{}, points);
    connectivity = array(uint32_t{}, 3 * faces) + tables + slots;
  }
  kept += array(Group<Index>(), groups) + array(DepthFirstTraversal<Index>(), groups) +
          attributes *
              (array(Attribute<Index>(), 1) + array(SymbolSequence(), 1) + array(IntegerDecoder<Index>(), 1));
  reading = larger(reading, array(Attribute<Index>(), kMaxAttributes));
  // Values with room for a fourth component, corrections, symbols' tables, creases.
  kept += 4 * (points * (values.components + attributes) + points * values.components);
  kept += attributes * (tables + 64) + slots;
  kept += attributes * (array(uint8_t{}, 4 * points) + 64);
  predicting = array(uint8_t{}, points) + array(Index{}, 4 * points) + sizeof(Index) * (mark + faces);
  const size_t walking = 2 * array(Index{}, points);
  return kept + larger(larger(connectivity, reading), larger(predicting, walking));
}

}  // namespace psplit::core
