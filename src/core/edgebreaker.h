// Edgebreaker: decodes a string of C, L, E, R, S to a corner table, backwards, one face for each symbol.
//
// J. Rossignac: Edgebreaker, 1999; M. Isenburg, J. Snoeyink: Spirale Reversi, 1999; Draco bitstream
// specification 2.2.
//
// The part of the mesh that is decoded has a border: loops of directed edges, with the mesh on their right. One
// edge of it is active. Each symbol adds the face (v0, v1, v2) with corners 0, 1, 2 on its far side, here from
// above:
//
//           C                    L                      R                      S                      E
//
//   from ======= v1      from ======= x           x ======= to         from ======= v1        x+2 ======= x+1
//      \ 2   1 /            \ 2   1 /             \ 2   1 /               \ 2   1 /               \ 2   1 /
//  active\   / b        active\   /                 \   / active       active\   / b                \   /
//         \0/                  \0/                   \0/                      \0/                    \0/
//   ------ to ------     ------ to ------     ------ from ------       ------ n,p ------              x
//
// C closes vertex `to` between the active edge and the next border edge, b. L and R bring a new vertex x. S
// joins the active edge to an edge b elsewhere on the border, which starts at vertex p; vertex n = `to` becomes
// part of p. E starts a component of three new vertices. The new active edge (=) always lies across from corner
// 0, from v2 to v1.
//
//      v0   v1                 v2     active meets  b meets  the border gets border[v2] = {c0, v1} and
//   C  to   border[to].beyond  from   c1            c2       -
//   L  to   x                  from   c1            -        border[x] = {c2, to}
//   R  from to                 x      c2            -        border[from] = {c1, x}
//   S  p    the end of b       from   c1            c2       border[p] = border[n]
//   E  x    x+1                x+2    -             -        border[v0] = {c1, v2}, border[v1] = {c2, v0}
#pragma once

#include "src/core/edgebreaker_symbols.h"
#include "src/core/fault.h"
#include "src/core/rans.h"

namespace psplit::core {

// The edges that wait for an S to be joined: active edges of components whose decoding is interrupted, in a
// stack, and edges that split events set aside.
template <typename Index>
class WaitingEdges {
 public:
  // The sources of `events` never ascend, and their splits are below symbol_count, as read_split_events has it.
  PSPLIT_HD Fault start(View<const SplitEvent> events, uint32_t symbol_count, Arena& arena) {
    if (!arena.take(stack_, symbol_count)) return Fault::kWorkspace;
    events_ = events;
    if (events.empty()) return Fault::kNone;
    if (!arena.take(set_aside_, symbol_count)) return Fault::kWorkspace;
    fill(set_aside_, kNone<Index>);
    find_source();
    return Fault::kNone;
  }
  // The memory that `start` takes.
  PSPLIT_HD static size_t bytes(const ConnectivityCounts& counts) {
    return (counts.split_count > 0 ? 2 : 1) * Arena::bytes<Index>(counts.symbol_count);
  }

  PSPLIT_HD void push(uint32_t edge) {
    if constexpr (PSPLIT_MOVES_ROWS) {
      stack_[stack_size_++] = top_.edge;
      top_.edge = static_cast<Index>(edge);
    } else {
      stack_[stack_size_++] = static_cast<Index>(edge);
    }
  }
  // kNone from an empty stack.
  PSPLIT_HD uint32_t pop() {
    if constexpr (!PSPLIT_MOVES_ROWS) {
      return stack_size_ > 0 ? stack_[--stack_size_] : kNone<Index>;
    } else {
      const Index edge = top_.edge;
      if (stack_size_ > 0) top_.edge = stack_[--stack_size_];
      return edge;
    }
  }
  // The edge for the S that is symbol i.
  PSPLIT_HD uint32_t take(uint32_t i) {
    const uint32_t edge = set_aside_.empty() ? kNone<Index> : set_aside_[i];
    return edge != kNone<Index> ? edge : pop();
  }

  PSPLIT_HD bool is_source(uint32_t i) const { return i == source_; }
  // Symbol i is a source: sets edges of its face aside.
  PSPLIT_HD void set_aside(uint32_t i) {
    for (; !events_.empty() && events_[events_.size() - 1].source == i;
         events_ = events_.first(events_.size() - 1)) {
      const SplitEvent& event = events_[events_.size() - 1];
      if (event.split > i)
        set_aside_[event.split] = static_cast<Index>(4 * i + (event.right_edge != 0 ? 1 : 2));
    }
    find_source();
  }
  PSPLIT_HD bool events_left() const { return !events_.empty(); }

 private:
  PSPLIT_HD void find_source() { source_ = events_.empty() ? ~0u : events_[events_.size() - 1].source; }

  View<Index> stack_;
  uint32_t stack_size_ = 0;
  // For devices: the edge on top is not in the array, so that no S waits for a load.
  struct Top {
    Index edge = kNone<Index>;
  };
  [[no_unique_address]] ForDevices<Top> top_;
  View<const SplitEvent> events_;  // those to come, the next one last
  uint32_t source_ = ~0u;          // of the next event
  View<Index> set_aside_;          // by symbol; empty without events
};

// Links the corners on both sides of an edge.
template <typename Index>
PSPLIT_HD void link(View<Index> opposite, uint32_t a, uint32_t b) {
  opposite[a] = static_cast<Index>(b);
  opposite[b] = static_cast<Index>(a);
}

// How add_faces stores the faces. There are two ways to the same mesh: every number at once, or whole rows of
// the table when they are complete. They differ in their stores and loads, not in their results.
template <typename Index, bool kMovesRows>
class FaceRows;

// Stores every number at once, even if the next symbol overwrites it: C, L and R have equal stores, without a
// branch between them.
template <typename Index>
class FaceRows<Index, false> {
 public:
  static constexpr bool kStoresAll = true;

  PSPLIT_HD explicit FaceRows(const Connectivity<Index>& mesh)
      : opposite_(mesh.table.opposite), vertex_(mesh.table.vertex), border_(mesh.border) {}

  // The border edge that leaves `to`, for C. `if_c` and `if_r` are masks.
  PSPLIT_HD BorderEdge<Index> edge_after(uint32_t to, uint32_t) const { return border_[to]; }
  // C, L or R: links the new face c0 / 4 with the active edge, and if it is C, with edge b.
  PSPLIT_HD void attach(uint32_t c0, uint32_t active, uint32_t b, uint32_t if_c, uint32_t if_r) {
    const uint32_t c2 = c0 + 2, unused = c0 + 3;
    link(opposite_, active, c0 + 1 - if_r);
    // L and R link the unused fourth corner of the face with itself, in place of b and c2.
    const uint32_t across = select(if_c, b, unused);
    opposite_[across] = static_cast<Index>(c2);
    opposite_[unused + if_c] = static_cast<Index>(across);
  }
  // S: links the new face with both edges.
  PSPLIT_HD void join(uint32_t c0, uint32_t active, uint32_t b) {
    link(opposite_, active, c0 + 1);
    link(opposite_, b, c0 + 2);
  }
  // E: the new face has no neighbours.
  PSPLIT_HD void begin_component() {}
  PSPLIT_HD void set_vertices(uint32_t c0, uint32_t v0, uint32_t v1, uint32_t v2) {
    vertex_[c0] = static_cast<Index>(v0);
    vertex_[c0 + 1] = static_cast<Index>(v1);
    vertex_[c0 + 2] = static_cast<Index>(v2);
  }
  // The last face, c0 / 4, is looked at otherwise than by the next C, L or R.
  PSPLIT_HD void store_last(uint32_t) {}
  // The corner across from corner 2 of the last face, which is `corner`.
  PSPLIT_HD Index across_from(uint32_t corner) const { return opposite_[corner]; }

 private:
  View<Index> opposite_, vertex_;
  View<BorderEdge<Index>> border_;
};

// Whole rows, for devices: they store for many threads at once. The symbol after a face nearly always
// determines the corner opposite its corner 0, and two rows of vertices are stored together. Opposite corners
// of earlier faces are stored at once.
template <typename Index>
class FaceRows<Index, true> {
 public:
  static constexpr bool kStoresAll = false;

  PSPLIT_HD explicit FaceRows(const Connectivity<Index>& mesh)
      : opposite_(mesh.table.opposite), vertex_(mesh.table.vertex), border_(mesh.border) {}

  PSPLIT_HD BorderEdge<Index> edge_after(uint32_t to, uint32_t if_c) const {
    return if_c != 0 ? border_[to] : BorderEdge<Index>(0, 0);
  }
  PSPLIT_HD void attach(uint32_t c0, uint32_t active, uint32_t b, uint32_t if_c, uint32_t if_r) {
    constexpr uint32_t kNo = kNone<Index>;
    if (if_c != 0) link_to(active, b, c0 + 2);
    last_.at[0] = static_cast<Index>(c0 + 1 - if_r);
    row_of(opposite_, active) = last_;
    begin_face(select(if_r, kNo, active), if_r != 0 ? active : if_c != 0 ? b : kNo);
  }
  PSPLIT_HD void join(uint32_t c0, uint32_t active, uint32_t b) {
    opposite_[active] = static_cast<Index>(c0 + 1);
    opposite_[b] = static_cast<Index>(c0 + 2);
    begin_face(active, b);
  }
  PSPLIT_HD void begin_component() { begin_face(kNone<Index>, kNone<Index>); }
  PSPLIT_HD void set_vertices(uint32_t c0, uint32_t v0, uint32_t v1, uint32_t v2) {
    const FaceRow<Index> row{
        {static_cast<Index>(v0), static_cast<Index>(v1), static_cast<Index>(v2), Index{0}}};
    if (!has_even_) {
      if ((c0 & 4) != 0)
        row_of(vertex_, c0) = row;
      else
        even_ = row, has_even_ = true;
      return;
    }
    reinterpret_cast<RowPair&>(row_of(vertex_, c0 - 4)) = {even_, row};
    has_even_ = false;
  }
  PSPLIT_HD void store_last(uint32_t c0) {
    row_of(opposite_, c0) = last_;
    if (has_even_) row_of(vertex_, c0) = even_;
    has_even_ = false;
  }
  PSPLIT_HD Index across_from(uint32_t) const { return last_.at[2]; }

 private:
  struct alignas(16) RowPair {
    FaceRow<Index> even, odd;
  };

  // Records the corner opposite a corner of the last face, c0 / 4, or of an earlier face.
  PSPLIT_HD void link_to(uint32_t c0, uint32_t corner, uint32_t across) {
    if (corner - c0 < 4) {
      if (corner == c0 + 1) last_.at[1] = static_cast<Index>(across);
      if (corner == c0 + 2) last_.at[2] = static_cast<Index>(across);
    } else {
      opposite_[corner] = static_cast<Index>(across);
    }
  }
  // The corners opposite to corners 1 and 2 of the new last face.
  PSPLIT_HD void begin_face(uint32_t across_1, uint32_t across_2) {
    last_ = {{kNone<Index>, static_cast<Index>(across_1), static_cast<Index>(across_2), kNone<Index>}};
  }

  View<Index> opposite_, vertex_;
  View<BorderEdge<Index>> border_;
  FaceRow<Index> last_{}, even_{};
  bool has_even_ = false;
};

// Adds a face for each symbol; requires one or more symbols. All of its state is local to this function, so
// that it stays in registers. It tells `symbols` about each face (added), and about vertices that S merged. If
// `symbols` has brought(vertex, corner), it also says at which corner a vertex is new. C brings no vertex, but
// may call it as well: the symbol that brings that vertex calls it again. If `symbols` has finish(), it is
// called after the last symbol.
//
// The symbols may be anything, and yet loads and stores need no checks. Before symbol i:
//   - Faces 0 to i - 1 exist. Their vertices are below vertex_count, which does not exceed the limit, and the
//     arrays have room for three more.
//   - The border edges are the corners without an opposite corner. For each vertex v of the border, one of them
//     enters it, and one leaves it: border[v]. Swinging left from the one that enters to the one that leaves
//     meets all corners of v.
//   - The active edge is one of them: border[from] is {active, to}. It is stored when a symbol may load it: a
//     device stores it only before E, at the end, and in strings that will be refused.
// Each row of the table preserves this:
//   - C takes `to` off the border. Only the active edge entered it. C may also write border[x], though there
//     is no vertex x yet; the symbol that brings vertex x overwrites that.
//   - S takes n off the border. It checks that b is a border edge and not the active one, and that p is not n.
//     Then p is not `from` either, for one border edge leaves each vertex. Only the active edge entered n, so b
//     does not, and v1 is not n. The corners of n are a chain that ends at the border, so relabelling them
//     ends. A border edge from n to p becomes a loop from p to p, which is an edge like any other.
//   - If v1 = v2, the new active edge is a loop: the string is degenerate, and is refused. C, L and R find
//     their border edges all the same, so the loop over the symbols goes on without a branch for this case, and
//     refuses the string at its end. But a C here links one edge to two corners, so that the corners of a
//     vertex may no longer be a chain. Only S follows chains, and refuses the string at once.
// The stack of waiting edges gets at most one edge for each E after the first, and one at the end: no more than
// there are symbols.
template <bool kMovesRows = PSPLIT_MOVES_ROWS, typename Index, typename Symbols>
PSPLIT_HD Fault add_faces(Symbols symbols, WaitingEdges<Index>& waiting, Connectivity<Index>& result) {
  using Rows = FaceRows<Index, kMovesRows>;
  typename CopyIf<kMovesRows, Connectivity<Index>>::Type mesh = result;
  const ConnectivityCounts counts = mesh.counts;
  const View<Index> opposite = mesh.table.opposite, vertex = mesh.table.vertex;
  const View<BorderEdge<Index>> border = mesh.border;
  uint32_t active = 0, from = 0, to = kNone<Index>, vertex_count = 0;
  bool degenerate = false;
  Rows rows(mesh);
  const auto brought = [&](uint32_t v, uint32_t corner) {
    if constexpr (requires { symbols.brought(v, corner); }) symbols.brought(v, corner);
  };
  const auto set_active_aside = [&] {
    waiting.push(active);
    if constexpr (!Rows::kStoresAll) rows.store_last(active), border[from] = {active, to};
  };
  for (uint32_t i = 0; i < counts.symbol_count; ++i) {
    const uint32_t symbol = symbols.next(to);
    const uint32_t c0 = 4 * i, c1 = c0 + 1, c2 = c0 + 2, x = vertex_count;
    uint32_t v0, v1, v2;
    if (PSPLIT_LIKELY(is_clr(symbol))) {
      // A processor cannot predict which of the three comes: masks choose between the rows of the table.
      if (PSPLIT_UNLIKELY(i == 0)) return Fault::kConnectivity;
      const uint32_t if_c = (symbol & 1) - 1, if_r = 0 - (symbol >> 2);
      // The next symbol waits for v1, which waits for this load. All else is chosen before it comes.
      const BorderEdge<Index> b = rows.edge_after(to, if_c);
      v0 = select(if_r, from, to), v2 = select(if_r, x, from);
      v1 = select(if_c, b.beyond(), select(if_r, to, x));
      if (Rows::kStoresAll || if_c == 0) {
        border[select(if_r, from, x)] = {c2 + if_r, select(if_r, x, to)};
        brought(x, c1 - if_r);
      }
      rows.attach(c0, active, b.corner(), if_c, if_r);
      vertex_count += 1 + if_c;
    } else if (symbol == kS) {
      if (i == 0 || degenerate) return Fault::kConnectivity;
      rows.store_last(active);
      const uint32_t b = waiting.take(i);
      if (b == kNone<Index>) return Fault::kConnectivity;
      // All three are loaded before one of them is looked at.
      const uint32_t across = opposite[b], p = vertex[previous(b)], n = to;
      v0 = p, v1 = vertex[next(b)], v2 = from;
      if (across != kNone<Index> || p == n) return Fault::kConnectivity;
      symbols.merged(p, n);
      mesh.merge(n, p, next(active), rows.across_from(previous(active)));
      rows.join(c0, active, b);
    } else if (symbol == kE) {
      if (i > 0) set_active_aside();
      rows.begin_component();
      v0 = x, v1 = x + 1, v2 = x + 2;
      brought(v0, c0), brought(v1, c1), brought(v2, c2);
      vertex_count += 3;
      border[v0] = {c1, v2};
      border[v1] = {c2, v0};
    } else {
      return Fault::kConnectivity;
    }
    if (PSPLIT_UNLIKELY(vertex_count > counts.vertex_limit)) return Fault::kCounts;
    rows.set_vertices(c0, v0, v1, v2);
    degenerate |= v1 == v2;
    if (Rows::kStoresAll || degenerate) border[v2] = {c0, v1};
    symbols.added(symbol, v0, v1, v2);
    active = c0, from = v2, to = v1;
    if (PSPLIT_UNLIKELY(waiting.is_source(i))) {
      // Only symbols that bring a vertex have events.
      if (symbol == kC || symbol == kS) return Fault::kSplitEvent;
      waiting.set_aside(i);
    }
  }
  if constexpr (requires { symbols.finish(); }) symbols.finish();
  if (waiting.events_left()) return Fault::kSplitEvent;
  if (degenerate) return Fault::kConnectivity;
  set_active_aside();
  result.vertex_count = vertex_count;
  result.merged_count = mesh.merged_count;
  return Fault::kNone;
}

// An encoder begins each component at a border, or at a face that it leaves out. So when all symbols are
// decoded, each component has a border that is real, or a hole for that face: the start face. A bit for each
// waiting edge says which. Start faces come after the faces of the symbols.
template <typename Index, typename StartFaces>
PSPLIT_HD Fault add_start_faces(StartFaces& start_faces, WaitingEdges<Index>& waiting,
                                Connectivity<Index>& mesh) {
  const View<Index> opposite = mesh.table.opposite, vertex = mesh.table.vertex;
  uint32_t face_count = mesh.counts.symbol_count;
  for (uint32_t a = waiting.pop(); a != kNone<Index>; a = waiting.pop()) {
    if (!start_faces.next()) continue;
    if (face_count == mesh.counts.face_count) return Fault::kCounts;
    // The hole should have the border edges a, b and c, from p to n to x and back to p. As in add_faces, one
    // border edge leaves each vertex of the border: so b and c exist, and a, b and c are three edges, unless a
    // is a loop.
    if (opposite[a] != kNone<Index>) return Fault::kConnectivity;
    const uint32_t p = vertex[previous(a)], n = vertex[next(a)];
    const uint32_t b = mesh.border[n].corner(), x = vertex[next(b)], c = mesh.border[x].corner();
    if (b == a || vertex[next(c)] != p) return Fault::kConnectivity;
    const uint32_t c0 = 4 * face_count++;
    link(opposite, a, c0);
    link(opposite, b, c0 + 1);
    link(opposite, c, c0 + 2);
    vertex[c0] = static_cast<Index>(x);
    vertex[c0 + 1] = static_cast<Index>(p);
    vertex[c0 + 2] = static_cast<Index>(n);
  }
  return face_count == mesh.counts.face_count ? Fault::kNone : Fault::kCounts;
}

// The memory that decode_connectivity takes, and gives back.
template <typename Index>
PSPLIT_HD size_t connectivity_scratch_bytes(const ConnectivityCounts& counts) {
  return WaitingEdges<Index>::bytes(counts);
}

// Decodes all symbols, which may be anything, and adds the components' start faces. `mesh` has its counts and
// its memory, `opposite` is kNone everywhere, and `waiting` is started.
// `start_faces` says for each component whether it has a start face.
template <bool kMovesRows = PSPLIT_MOVES_ROWS, typename Index, typename Symbols, typename StartFaces>
PSPLIT_HD Fault add_all_faces(Symbols symbols, WaitingEdges<Index> waiting, StartFaces& start_faces,
                              Connectivity<Index>& mesh) {
  const ConnectivityCounts& counts = mesh.counts;
  if (counts.symbol_count == 0) return counts.face_count == 0 ? Fault::kNone : Fault::kCounts;
  const Fault fault = add_faces<kMovesRows>(symbols, waiting, mesh);
  return fault == Fault::kNone ? add_start_faces(start_faces, waiting, mesh) : fault;
}

// Decodes the whole connectivity: add_all_faces, with the steps before and after it. On success the arena is as
// before, every corner has its vertex, every pair of opposite corners names each other, and each vertex that is
// not merged has one fan of faces.
template <bool kMovesRows = PSPLIT_MOVES_ROWS, typename Index, typename Symbols, typename StartFaces>
PSPLIT_HD Fault decode_connectivity(Symbols symbols, View<const SplitEvent> events, StartFaces& start_faces,
                                    Arena& arena, Connectivity<Index>& mesh) {
  fill(mesh.table.opposite, kNone<Index>);
  const size_t mark = arena.mark();
  WaitingEdges<Index> waiting;
  Fault fault = waiting.start(events, mesh.counts.symbol_count, arena);
  if (fault == Fault::kNone) fault = add_all_faces<kMovesRows>(symbols, waiting, start_faces, mesh);
  if (fault != Fault::kNone) return fault;
  mesh.find_closed_vertices(SerialLanes());
  arena.release(mark);
  return Fault::kNone;
}

}  // namespace psplit::core
