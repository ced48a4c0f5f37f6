// Edgebreaker's other end: turns a corner table into a string of C, L, E, R, S. The order of faces, symbols and
// events is that of libdraco's encoder.
//
// J. Rossignac: Edgebreaker, 1999; Draco bitstream specification 2.2. src/core/edgebreaker.h decodes the
// symbols, in reverse.
//
// A walk goes from face to face. It enters a face through an edge, the gate (=). The vertex across from the
// gate is at the corner, c. The face on the right is across from next(c), the face on the left across from
// previous(c). A face counts as visited if there is none.
//
//               c
//              /v\               v is new, inside the mesh       C   goes right; comes back on the left
//       left  /   \  right       only the left face is visited   L   goes right
//            /     \             only the right face is visited  R   goes left
//           /n     p\            neither is visited              S   goes right, and left when it comes back
//          *=========*           both are visited                E   goes back to the last S
//              gate
//
// If v is new and on the border, both faces are unvisited: the walk has met a hole, and knows all its vertices
// from then on. An S that is met again from another side, through the left face that waits, closes a handle: an
// event notes the symbol that met it.
#pragma once

#include <vector>

#include "encoder/stream/source_table.h"
#include "src/core/edgebreaker_symbols.h"

namespace psplit {

// All vectors are in the order of decoding.
struct Traversal {
  std::vector<uint8_t> symbols;                // core::Clers
  std::vector<core::SplitEvent> split_events;  // in the order of the stream
  std::vector<uint8_t> start_faces;            // by component: 1 if it begins with a face without a symbol
  // The source corner of each face's corner 0: of the faces of symbols, then of the start faces.
  std::vector<uint32_t> corners;
};

// Visits all faces, and marks them and their vertices.
Traversal traverse_faces(SourceTable& table);

}  // namespace psplit
