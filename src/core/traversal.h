// The order in which an attribute's values are stored: a walk over the faces of its corner table that visits
// every vertex once. Draco bitstream specification 2.2, "edgebreaker traversal" and "prediction degree
// traversal".
#pragma once

#include "src/core/seams.h"

namespace psplit::core {

// Vertices in the order of their values.
template <typename Index>
struct Sequence {
  View<Index> corner;  // at which the walk met each
  View<Index> rank;    // by vertex, its place in the sequence
  uint32_t count = 0;
};

// What a walk has seen.
template <typename Index>
class Walk {
 public:
  PSPLIT_HD Fault start(const AttributeTable<Index>& attribute, Arena& arena, Sequence<Index>& out) {
    table_ = attribute.table;
    closed_ = attribute.closed;
    const size_t corner_count = attribute.table.opposite.size();
    if (!arena.take(out.corner, size_t{attribute.vertex_count} + 1)) return Fault::kWorkspace;
    if (!arena.take(out.rank, attribute.vertex_count)) return Fault::kWorkspace;
    mark_ = arena.mark();
    if (!arena.take(face_seen_, corner_count / 4)) return Fault::kWorkspace;
    fill(face_seen_, false);
    fill(out.rank, kNone<Index>);
    met_ = out.corner;
    rank_ = out.rank;
    return Fault::kNone;
  }
  PSPLIT_HD void finish(Arena& arena, Sequence<Index>& out) const {
    out.count = count_;
    arena.release(mark_);
  }

  PSPLIT_HD Index right_of(Index corner) const { return table_.opposite[next(corner)]; }
  PSPLIT_HD Index left_of(Index corner) const { return table_.opposite[previous(corner)]; }
  PSPLIT_HD bool closed_at(Index corner) const { return closed_[table_.vertex[corner]]; }
  PSPLIT_HD Index vertex_at(Index corner) const { return table_.vertex[corner]; }

  PSPLIT_HD bool face_seen(Index corner) const { return face_seen_[corner >> 2]; }
  PSPLIT_HD bool face_done(Index corner) const { return corner == kNone<Index> || face_seen(corner); }
  PSPLIT_HD void see_face(Index corner) { face_seen_[corner >> 2] = true; }
  PSPLIT_HD bool vertex_seen(Index corner) const { return rank_[vertex_at(corner)] != kNone<Index>; }

  // Whether the vertex at the corner is a new one; if so it comes next in the sequence.
  PSPLIT_HD bool see_vertex(Index corner) {
    Index& rank = rank_[vertex_at(corner)];
    const bool is_new = rank == kNone<Index>;
    met_[count_] = corner;
    rank = static_cast<Index>(select(mask(is_new), count_, rank));
    count_ += is_new;
    return is_new;
  }

 private:
  CornerTable<Index> table_;
  View<bool> closed_, face_seen_;
  View<Index> met_, rank_;
  uint32_t count_ = 0;
  size_t mark_ = 0;
};

// Depth first: to the right while that leads anywhere, the left sides kept for later.
template <typename Index>
PSPLIT_HD Fault traverse_depth_first(const AttributeTable<Index>& attribute, Arena& arena,
                                     Sequence<Index>& out) {
  Walk<Index> walk;
  const size_t face_count = attribute.table.opposite.size() / 4;
  if (const Fault fault = walk.start(attribute, arena, out); fault != Fault::kNone) return fault;
  View<Index> stack;
  if (!arena.take(stack, face_count + 1)) return Fault::kWorkspace;
  for (size_t start = 0; start < face_count; ++start) {
    auto corner = static_cast<Index>(4 * start);
    if (walk.face_seen(corner)) continue;
    walk.see_vertex(next(corner));
    walk.see_vertex(previous(corner));
    size_t waiting = 0;
    for (;;) {
      walk.see_face(corner);
      const bool inside = walk.see_vertex(corner) && walk.closed_at(corner);
      const Index right = walk.right_of(corner), left = walk.left_of(corner);
      const bool right_done = walk.face_done(right), left_done = walk.face_done(left);
      // Around a new vertex inside the mesh nothing is done yet, and the walk comes back on the left by itself.
      stack[waiting] = left;
      waiting += !inside & !right_done & !left_done ? 1 : 0;
      if (!right_done) {
        corner = right;
      } else if (!left_done) {
        corner = left;
      } else {
        while (waiting > 0 && walk.face_seen(stack[waiting - 1])) --waiting;
        if (waiting == 0) break;
        corner = stack[--waiting];
      }
    }
  }
  walk.finish(arena, out);
  return Fault::kNone;
}

// By prediction degree: first to faces whose vertices are all seen, then to those whose new vertex other faces
// can predict as well.
template <typename Index>
PSPLIT_HD Fault traverse_by_prediction_degree(const AttributeTable<Index>& attribute, Arena& arena,
                                              Sequence<Index>& out) {
  Walk<Index> walk;
  const size_t face_count = attribute.table.opposite.size() / 4;
  if (const Fault fault = walk.start(attribute, arena, out); fault != Fault::kNone) return fault;
  constexpr uint32_t kPriorities = 3;
  View<uint8_t> degree;
  // Every edge is put on a stack at most once, from its first side. Three stacks in one linked array.
  View<Index> waiting[kPriorities];
  uint32_t sizes[kPriorities] = {};
  if (!arena.take(degree, attribute.vertex_count)) return Fault::kWorkspace;
  for (View<Index>& stack : waiting)
    if (!arena.take(stack, 2 * face_count + 1)) return Fault::kWorkspace;
  fill(degree, uint8_t{0});
  uint32_t best = 0;
  const auto priority_of = [&](Index corner) -> uint32_t {
    if (walk.vertex_seen(corner)) return 0;
    uint8_t& seen_from = degree[walk.vertex_at(corner)];
    if (seen_from < 2) ++seen_from;
    return seen_from > 1 ? 1 : 2;
  };
  const auto wait = [&](Index corner, uint32_t priority) {
    waiting[priority][sizes[priority]++] = corner;
    if (priority < best) best = priority;
  };

  for (size_t start = 0; start < face_count; ++start) {
    auto corner = static_cast<Index>(4 * start);
    if (walk.face_seen(corner)) continue;
    walk.see_vertex(next(corner));
    walk.see_vertex(previous(corner));
    walk.see_vertex(corner);
    wait(corner, 0);
    best = 0;
    for (;;) {
      while (best < kPriorities && sizes[best] == 0) ++best;
      if (best == kPriorities) break;
      corner = waiting[best][--sizes[best]];
      if (walk.face_seen(corner)) continue;
      for (;;) {
        walk.see_face(corner);
        walk.see_vertex(corner);
        const Index right = walk.right_of(corner), left = walk.left_of(corner);
        const bool right_done = walk.face_done(right);
        if (!walk.face_done(left)) {
          const uint32_t priority = priority_of(left);
          if (right_done && priority <= best) {
            corner = left;
            continue;
          }
          wait(left, priority);
        }
        if (!right_done) {
          const uint32_t priority = priority_of(right);
          if (priority <= best) {
            corner = right;
            continue;
          }
          wait(right, priority);
        }
        break;
      }
    }
  }
  walk.finish(arena, out);
  return Fault::kNone;
}

}  // namespace psplit::core
