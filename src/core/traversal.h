// The order in which an attribute's values are stored: a walk over the faces of its corner table that meets
// every vertex. Draco bitstream specification 2.2, "edgebreaker traversal" and "prediction degree traversal".
#pragma once

#include "src/core/lanes.h"
#include "src/core/seams.h"

namespace psplit::core {

// The vertices in the order of their values.
template <typename Index>
struct Sequence {
  View<Index> corner;  // the corner at which the walk met each vertex
  View<Index> rank;    // by vertex: its place in the sequence
  uint32_t count = 0;

  PSPLIT_HD bool allocate(uint32_t vertex_count, Arena& arena) {
    count = vertex_count;
    // A walk stores a corner after the last vertex before it finds out that the corner's vertex is not new.
    // That element always holds a valid corner.
    if (!arena.take_for_good(corner, uint64_t{vertex_count} + 1) || !arena.take_for_good(rank, vertex_count))
      return false;
    corner[vertex_count] = 0;
    return true;
  }
  // The memory that allocate takes.
  PSPLIT_HD static size_t bytes(uint64_t vertex_count) {
    return Arena::bytes<Index>(vertex_count + 1) + Arena::bytes<Index>(vertex_count);
  }
};

// The faces and vertices that a walk has seen. The answers are the numbers 0 and 1 instead of bool, so that
// compilers do not make branches of them.
template <typename Index>
class Walk {
 public:
  // The walk is written to `out`, which is allocated. `begin` has to follow.
  PSPLIT_HD Fault allocate(const AttributeTable<Index>& attribute, Arena& arena, const Sequence<Index>& out) {
    table_ = attribute.table;
    closed_ = attribute.closed;
    face_count_ = unseen_count_ = static_cast<uint32_t>(table_.opposite.size() / 4);
    met_ = out.corner;
    rank_ = out.rank;
    return face_seen_.take(face_count_, arena) ? Fault::kNone : Fault::kWorkspace;
  }
  // No face and no vertex is seen. Collective.
  template <Lanes L>
  PSPLIT_HD void begin(L lanes) {
    fill(lanes, face_seen_.all(), false);
    if (lanes.rank() == 0) face_seen_.of_none() = true;
    for_each_lane_item(lanes, static_cast<uint32_t>(rank_.size()), [&](uint32_t v) {
      rank_[v] = static_cast<Index>(kUnseenOpen - static_cast<uint32_t>(closed_[v]));
    });
    lanes.sync();
  }
  // The memory that `allocate` takes.
  PSPLIT_HD static size_t bytes(uint32_t face_count) { return FaceValues<Index, bool>::bytes(face_count); }
  PSPLIT_HD void give_back(Arena& arena) { face_seen_.give_back(arena); }
  // The walk visits every face, so it meets every vertex that has a corner. A vertex without corners is a
  // fault.
  PSPLIT_HD Fault finish() const { return count_ == rank_.size() ? Fault::kNone : Fault::kConnectivity; }

  PSPLIT_HD uint32_t face_count() const { return face_count_; }
  // What a step needs of a face.
  struct Neighbours {
    uint32_t right, left, vertex;
  };
  PSPLIT_HD Neighbours neighbours(uint32_t corner) const {
    if constexpr (!PSPLIT_MOVES_ROWS) return {right_of(corner), left_of(corner), vertex_at(corner)};
    return rows(corner).neighbours(corner);
  }
  // The rows of a corner's face; any rows if the corner has no face.
  struct Rows {
    FaceRow<Index> opposite, vertex;
    PSPLIT_HD Neighbours neighbours(uint32_t corner) const {
      return {opposite[next(corner) & 3], opposite[previous(corner) & 3], vertex[corner & 3]};
    }
  };
  PSPLIT_HD Rows rows(uint32_t corner) const {
    const uint32_t at = corner == kNone<Index> ? 0 : corner;
    return {row_of(table_.opposite, at), row_of(table_.vertex, at)};
  }
  PSPLIT_HD uint32_t right_of(uint32_t corner) const { return table_.opposite[next(corner)]; }
  PSPLIT_HD uint32_t left_of(uint32_t corner) const { return table_.opposite[previous(corner)]; }
  PSPLIT_HD uint32_t vertex_at(uint32_t corner) const { return table_.vertex[corner]; }

  PSPLIT_HD uint32_t face_seen(uint32_t corner) const { return face_seen_.of_face(corner); }
  // Like face_seen, but 1 if there is no face.
  PSPLIT_HD uint32_t face_done(uint32_t corner) const { return face_seen_.at(corner); }
  // Loads the neighbours of a face that is visited soon.
  PSPLIT_HD void prefetch(uint32_t corner) const { PSPLIT_PREFETCH(&table_.opposite[corner]); }
  // To be called once for each face.
  PSPLIT_HD void see_face(uint32_t corner) {
    face_seen_.of_face(corner) = true;
    --unseen_count_;
  }
  PSPLIT_HD uint32_t unseen_count() const { return unseen_count_; }
  PSPLIT_HD bool vertex_seen(uint32_t vertex) const { return rank_[vertex] < kUnseenClosed; }

  // If the vertex at the corner is new, it comes next in the sequence. Returns whether it is new and closed.
  PSPLIT_HD uint32_t see_vertex(uint32_t corner) { return see_vertex(corner, vertex_at(corner)); }
  PSPLIT_HD uint32_t see_vertex(uint32_t corner, uint32_t vertex) {
    Index& rank = rank_[vertex];
    const uint32_t before = rank, is_new = before >= kUnseenClosed;
    if constexpr (PSPLIT_MOVES_ROWS) {
      if (is_new != 0) met_[count_] = static_cast<Index>(corner), rank = static_cast<Index>(count_);
      count_ += is_new;
      return before == kUnseenClosed;
    }
    met_[count_] = static_cast<Index>(corner);
    rank = static_cast<Index>(select(0 - is_new, count_, before));
    count_ += is_new;
    return before == kUnseenClosed;
  }

 private:
  // The ranks of vertices that are not seen yet, so that one load answers all questions about a vertex.
  static constexpr uint32_t kUnseenOpen = kNone<Index>, kUnseenClosed = kUnseenOpen - 1;

  CornerTable<Index> table_;
  View<const bool> closed_;
  FaceValues<Index, bool> face_seen_;
  View<Index> met_, rank_;
  uint32_t face_count_ = 0, unseen_count_ = 0, count_ = 0;
};

// Depth first: turns right as long as there is an unvisited face, and keeps the faces on the left for later.
template <typename Index>
class DepthFirstTraversal {
 public:
  // `allocate` and `begin` on one lane.
  PSPLIT_HD Fault start(const AttributeTable<Index>& attribute, Arena& arena, const Sequence<Index>& out) {
    const Fault fault = allocate(attribute, arena, out);
    if (fault == Fault::kNone) begin(SerialLanes());
    return fault;
  }
  PSPLIT_HD Fault allocate(const AttributeTable<Index>& attribute, Arena& arena, const Sequence<Index>& out) {
    if (const Fault fault = walk_.allocate(attribute, arena, out); fault != Fault::kNone) return fault;
    return arena.take(waiting_, uint64_t{walk_.face_count()} + 1) ? Fault::kNone : Fault::kWorkspace;
  }
  // Makes the steps ready. Collective.
  template <Lanes L>
  PSPLIT_HD void begin(L lanes) {
    walk_.begin(lanes);
    if (lanes.rank() == 0) begin_component();
    lanes.sync();
  }
  // The memory that `allocate` takes.
  PSPLIT_HD static size_t bytes(uint32_t face_count) {
    return Walk<Index>::bytes(face_count) + Arena::bytes<Index>(uint64_t{face_count} + 1);
  }
  PSPLIT_HD Fault finish() const { return walk_.finish(); }
  // Gives back the memory that `start` took, after all steps.
  PSPLIT_HD void give_back(Arena& arena) {
    walk_.give_back(arena);
    arena.give_back(waiting_);
  }
  PSPLIT_HD uint32_t steps_left() const { return walk_.unseen_count(); }

  // Visits one face. The way of the walk is unpredictable, so only dead ends have a branch.
  PSPLIT_HD PSPLIT_INLINE void step() {
    const uint32_t corner = corner_;
    Rows to_right, to_left;
    const auto [right, left, vertex] = neighbours();
    if constexpr (PSPLIT_MOVES_ROWS) to_right = walk_.rows(right), to_left = walk_.rows(left);
    walk_.see_face(corner);
    const uint32_t right_done = walk_.face_done(right), left_done = walk_.face_done(left);
    // Around a new vertex inside the mesh no face is done yet. The walk to the right goes around it, and comes
    // back on the left by itself.
    const uint32_t inside = walk_.see_vertex(corner, vertex), waits = (inside | right_done | left_done) ^ 1;
    if (!PSPLIT_MOVES_ROWS || waits != 0) waiting_[waiting_count_] = static_cast<Index>(left);
    waiting_count_ += waits;
    corner_ = select(0 - right_done, left, right);
    if constexpr (PSPLIT_MOVES_ROWS) rows_ = right_done != 0 ? to_left : to_right;
    if (PSPLIT_UNLIKELY((right_done & left_done) != 0)) go_back();
  }

 private:
  using Rows = typename Walk<Index>::Rows;

  PSPLIT_HD PSPLIT_INLINE typename Walk<Index>::Neighbours neighbours() const {
    if constexpr (PSPLIT_MOVES_ROWS)
      return rows_.neighbours(corner_);
    else
      return walk_.neighbours(corner_);
  }
  PSPLIT_HD PSPLIT_INLINE void go_back() {
    while (waiting_count_ > 0) {
      corner_ = waiting_[--waiting_count_];
      if constexpr (PSPLIT_MOVES_ROWS) rows_ = walk_.rows(corner_);
      if (walk_.face_seen(corner_) == 0) return;
    }
    begin_component();
  }
  PSPLIT_HD PSPLIT_INLINE void begin_component() {
    if (steps_left() == 0) return;
    while (walk_.face_seen(4 * start_) != 0) ++start_;
    corner_ = 4 * start_;
    if constexpr (PSPLIT_MOVES_ROWS) rows_ = walk_.rows(corner_);
    walk_.see_vertex(next(corner_));
    walk_.see_vertex(previous(corner_));
  }

  Walk<Index> walk_;
  View<Index> waiting_;
  uint32_t corner_ = 0, waiting_count_ = 0, start_ = 0;
  // For devices, where loads take long: the rows of the face at corner_. They are loaded together with the
  // marks that say whether the walk goes there.
  [[no_unique_address]] ForDevices<Rows> rows_;
};

// By prediction degree: goes first to faces whose vertices are all seen, then to faces whose new vertex can be
// predicted from two visited faces, then to all others.
template <typename Index>
class PredictionDegreeTraversal {
 public:
  // `allocate` and `begin` on one lane.
  PSPLIT_HD Fault start(const AttributeTable<Index>& attribute, Arena& arena, const Sequence<Index>& out) {
    const Fault fault = allocate(attribute, arena, out);
    if (fault == Fault::kNone) begin(SerialLanes());
    return fault;
  }
  PSPLIT_HD Fault allocate(const AttributeTable<Index>& attribute, Arena& arena, const Sequence<Index>& out) {
    if (const Fault fault = walk_.allocate(attribute, arena, out); fault != Fault::kNone) return fault;
    room_ = 2 * walk_.face_count() + 1;
    for (uint32_t priority = 0; priority < kPriorities; ++priority) top_[priority] = bottom(priority);
    return arena.take(degree_, attribute.vertex_count) && arena.take(waiting_, uint64_t{2} * room_)
               ? Fault::kNone
               : Fault::kWorkspace;
  }
  // Makes the steps ready. Collective.
  template <Lanes L>
  PSPLIT_HD void begin(L lanes) {
    walk_.begin(lanes);
    fill(lanes, degree_, uint8_t{0});
    if (lanes.rank() == 0) begin_component();
    lanes.sync();
  }
  // The memory that `allocate` takes.
  PSPLIT_HD static size_t bytes(uint32_t face_count, uint64_t vertex_count) {
    return Walk<Index>::bytes(face_count) + Arena::bytes<uint8_t>(vertex_count) +
           Arena::bytes<Index>(2 * (uint64_t{2} * face_count + 1));
  }
  PSPLIT_HD Fault finish() const { return walk_.finish(); }
  PSPLIT_HD uint32_t steps_left() const { return walk_.unseen_count(); }

  // Visits one face.
  PSPLIT_HD PSPLIT_INLINE void step() {
    const auto [right, left, vertex] = walk_.neighbours(corner_);
    walk_.see_face(corner_);
    walk_.see_vertex(corner_, vertex);
    Tip left_tip(left), right_tip(right);
    if constexpr (PSPLIT_MOVES_ROWS) {
      // All loads of both sides at once, so that they do not wait for each other.
      look_at(left_tip), look_at(right_tip);
    }
    const bool right_done = walk_.face_done(right) != 0;
    if (walk_.face_done(left) == 0) {
      const uint32_t priority = priority_of(left_tip);
      if (right_done && priority <= best_) {
        corner_ = left;
        return;
      }
      if (left_tip.vertex == right_tip.vertex) right_tip.degree = left_tip.degree;
      wait(left, priority);
    }
    if (!right_done) {
      const uint32_t priority = priority_of(right_tip);
      if (priority <= best_) {
        corner_ = right;
        return;
      }
      wait(right, priority);
    }
    go_back();
  }

 private:
  // Lower numbers come first.
  static constexpr uint32_t kPriorities = 3;

  // The vertex of a face beside the visited one, which the visited face may predict.
  struct Tip {
    PSPLIT_HD explicit Tip(uint32_t at) : corner(at) {}
    uint32_t corner, vertex = 0, degree = 0;
    bool is_seen = false;
  };
  // Whatever is loaded if there is no face is not used.
  PSPLIT_HD PSPLIT_INLINE void look_at(Tip& tip) const {
    tip.vertex = walk_.vertex_at(tip.corner == kNone<Index> ? corner_ : tip.corner);
    tip.is_seen = walk_.vertex_seen(tip.vertex);
    tip.degree = degree_[tip.vertex];
  }
  PSPLIT_HD PSPLIT_INLINE uint32_t priority_of(Tip& tip) {
    if constexpr (!PSPLIT_MOVES_ROWS) look_at(tip);
    if (tip.is_seen) return 0;
    if (tip.degree < 2) degree_[tip.vertex] = static_cast<uint8_t>(++tip.degree);
    return tip.degree > 1 ? 1 : 2;
  }
  PSPLIT_HD PSPLIT_INLINE void wait(uint32_t corner, uint32_t priority) {
    walk_.prefetch(corner);
    waiting_[move_top(priority, step_of(priority))] = static_cast<Index>(corner);
    if (priority < best_) best_ = priority;
  }
  PSPLIT_HD PSPLIT_INLINE void go_back() {
    for (;;) {
      if (best_ == kPriorities) return begin_component();
      const uint32_t top = move_top(best_, 0);
      if (top == bottom(best_)) {
        ++best_;
        continue;
      }
      const uint32_t back = 0 - step_of(best_);
      corner_ = waiting_[top + back];
      move_top(best_, back);
      if (walk_.face_seen(corner_) == 0) return;
    }
  }
  // The first stack grows upwards from the start of an array, the second one downwards from its end, and the
  // third one has an array of its own.
  PSPLIT_HD uint32_t bottom(uint32_t priority) const {
    return (priority > 0 ? room_ : 0) - (priority == 1 ? 1 : 0);
  }
  PSPLIT_HD static uint32_t step_of(uint32_t priority) { return priority == 1 ? ~uint32_t{0} : 1; }
  // Moves the top of a stack, and returns where it was. A device keeps the tops in registers, which have no
  // index.
  PSPLIT_HD PSPLIT_INLINE uint32_t move_top(uint32_t priority, uint32_t by) {
    if constexpr (!PSPLIT_MOVES_ROWS) {
      const uint32_t before = top_[priority];
      top_[priority] = before + by;
      return before;
    }
    uint32_t before = 0;
    PSPLIT_UNROLL
    for (uint32_t p = 0; p < kPriorities; ++p) {
      if (p != priority) continue;
      before = top_[p];
      top_[p] += by;
    }
    return before;
  }
  PSPLIT_HD PSPLIT_INLINE void begin_component() {
    if (steps_left() == 0) return;
    while (walk_.face_seen(4 * start_) != 0) ++start_;
    corner_ = 4 * start_;
    walk_.see_vertex(next(corner_));
    walk_.see_vertex(previous(corner_));
    best_ = 0;
  }

  Walk<Index> walk_;
  View<uint8_t> degree_;  // by vertex: the number of faces that can predict it, at most 2
  // The corners that wait, in a stack for each priority. A face adds at most two when it is visited, so the
  // stacks have room.
  View<Index> waiting_;
  uint32_t room_ = 0;  // of each of its two arrays
  uint32_t top_[kPriorities] = {};
  uint32_t best_ = 0;  // no corner waits with a better priority
  uint32_t corner_ = 0, start_ = 0;
};

// Makes the whole walk at once. On success the arena is as before afterwards.
template <typename Index>
PSPLIT_HD Fault traverse_by_prediction_degree(const AttributeTable<Index>& attribute, Arena& arena,
                                              const Sequence<Index>& out) {
  const size_t mark = arena.mark();
  PredictionDegreeTraversal<Index> walk;
  if (const Fault fault = walk.start(attribute, arena, out); fault != Fault::kNone) return fault;
  while (walk.steps_left() > 0) walk.step();
  arena.release(mark);
  return walk.finish();
}

// Makes the whole walk of either kind at once, for one thread. On success the arena is as before afterwards.
template <typename Index>
Fault traverse(const AttributeTable<Index>& attribute, bool by_prediction_degree, Arena& arena,
               const Sequence<Index>& out) {
  if (by_prediction_degree) return traverse_by_prediction_degree(attribute, arena, out);
  const size_t mark = arena.mark();
  DepthFirstTraversal<Index> walk;
  if (const Fault fault = walk.start(attribute, arena, out); fault != Fault::kNone) return fault;
  while (walk.steps_left() > 0) walk.step();
  arena.release(mark);
  return walk.finish();
}
// The memory that it takes and releases.
template <typename Index>
size_t traverse_bytes(bool by_prediction_degree, uint32_t face_count, uint64_t vertex_count) {
  return by_prediction_degree ? PredictionDegreeTraversal<Index>::bytes(face_count, vertex_count)
                              : DepthFirstTraversal<Index>::bytes(face_count);
}

}  // namespace psplit::core
