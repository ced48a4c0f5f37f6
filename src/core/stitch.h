// The border of a patch in walking order, from its corner table: what stitch maps count along.
// src/container/stitch.h has the definition, which knows of faces and points only.
#pragma once

#include "src/core/decode_patch.h"

namespace psplit::core {

enum class BorderKind : uint8_t {
  kWalked,     // the walk is complete
  kNoWalk,     // the patch has none: its border meets itself
  kIrregular,  // an edge of the border may have a twin elsewhere in the patch: go by the definition
};

// `walk` has the points of the border one loop after the other. Both arrays stay in the arena.
template <typename Index>
PSPLIT_HD Fault walk_border(const Patch<Index>& patch, Arena& arena, View<Index>& walk, BorderKind& kind) {
  const CornerTable<Index>& table = patch.table;
  const View<Index> point_at = patch.point_at;
  View<Index> successor;
  if (!arena.take(successor, patch.point_count)) return Fault::kWorkspace;
  fill(successor, kNone<Index>);
  // Points differ from vertices only where there are seams.
  const bool has_seams = !patch.corner_of_point.empty();
  size_t edge_count = 0;
  for (uint32_t face = 0; face < patch.face_count; ++face) {
    for (uint32_t c = 4 * face; c < 4 * face + 3; ++c) {
      const auto corner = static_cast<Index>(c);
      const Index across = table.opposite[corner], at_a = next(corner), at_b = previous(corner);
      const Index a = point_at[at_a], b = point_at[at_b];
      if (PSPLIT_LIKELY(across != kNone<Index>)) {
        if (PSPLIT_LIKELY(!has_seams) || (point_at[previous(across)] == a && point_at[next(across)] == b))
          continue;
      }
      if (successor[a] != kNone<Index>) {
        kind = BorderKind::kIrregular;
        return Fault::kNone;
      }
      successor[a] = b;
      ++edge_count;
      // Faces around `a` from here to the border's other end: none may come back along b -> a.
      Index at = at_a;
      do {
        if (point_at[previous(at)] == b) {
          kind = BorderKind::kIrregular;
          return Fault::kNone;
        }
        at = table.swing_left(at);
      } while (at != kNone<Index> && at != at_a && point_at[at] == a);
    }
  }
  if (!arena.take(walk, edge_count)) return Fault::kWorkspace;
  size_t length = 0;
  kind = BorderKind::kNoWalk;
  for (uint32_t start = 0; start < patch.point_count && length < edge_count; ++start) {
    if (successor[start] == kNone<Index>) continue;
    uint32_t at = start;
    do {
      const Index following = successor[at];
      if (following == kNone<Index>) return Fault::kNone;
      walk[length++] = static_cast<Index>(at);
      successor[at] = kNone<Index>;
      at = following;
    } while (at != start);
  }
  kind = BorderKind::kWalked;
  return Fault::kNone;
}

}  // namespace psplit::core
