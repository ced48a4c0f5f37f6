// Edgebreaker connectivity: a string of C, L, E, R, S to a corner table, backwards, one face a symbol.
//
// J. Rossignac: Edgebreaker, 1999; M. Isenburg, J. Snoeyink: Spirale Reversi, 1999; Draco bitstream
// specification 2.2. What is decoded so far has open borders, loops of directed edges. One edge is active, and
// each symbol adds the face on its far side:
//
//        .-------.            .-------.            .-------.             b-------a           (a new
//       / \b   a/ \          / \a   .              .  a/ \              / \     / \           component)
//      /   \   /   \        /   \  .                .  /   \           /   \   /   \            n
//     *-----x-----*        x-----*                  *-----x           *-----p,n-----*          / \   .
//      .  c . .             .r. .                    . .l.             .    /x\    .          /c  \  .
//         C                   R                        L                   S                 n --- n   E
//
// C closes vertex x between the active edge a and the border's next one, b. R and L bring a new vertex. S joins
// the active border b with the one below it on a stack, a, merging vertices p and n. E starts a new component.
// The new active edge is always the one opposite the new face's corner 0.
#pragma once

#include "src/core/corner_table.h"
#include "src/core/fault.h"
#include "src/core/rans.h"
#include "src/core/symbols.h"

namespace psplit::core {

// As the standard traversal writes them: C in one bit, the others in three.
enum Clers : uint32_t { kC = 0, kS = 1, kL = 3, kR = 5, kE = 7 };
PSPLIT_HD constexpr bool is_clr(uint32_t symbol) { return (0b00101001u >> symbol & 1) != 0; }

struct ConnectivityCounts {
  uint32_t face_count = 0;
  uint32_t vertex_limit = 0;  // encoded vertices, and one for each S
  uint32_t symbol_count = 0;
  uint32_t split_count = 0;
};

template <size_t kBytes>
struct WordOf {
  using Type = uint32_t;
};
template <>
struct WordOf<8> {
  using Type = uint64_t;
};

// Where a vertex's corners start, clockwise, and the border's edge that leaves it: the border runs on from
// `corner`'s edge to vertex `beyond`. For a closed vertex: what they were before it closed.
//
// Both in one word: what one step stores the next may load, and a load that spans two stores waits for both.
template <typename Index>
class BorderEdge {
 public:
  BorderEdge() = default;
  PSPLIT_HD BorderEdge(uint32_t corner, uint32_t beyond) : word_(corner | static_cast<Word>(beyond) << kBits) {}
  PSPLIT_HD Index corner() const { return static_cast<Index>(word_); }
  PSPLIT_HD Index beyond() const { return static_cast<Index>(word_ >> kBits); }

 private:
  static constexpr int kBits = 8 * sizeof(Index);
  using Word = typename WordOf<2 * sizeof(Index)>::Type;
  Word word_;
};

template <typename Index>
struct Connectivity {
  ConnectivityCounts counts;
  CornerTable<Index> table;
  View<BorderEdge<Index>> border;  // by vertex; corner is kNone for a vertex that S merged into another
  View<bool> closed;               // by vertex: lies on no border
  View<Index> merged;              // vertices that S merged into others, in order
  uint32_t vertex_count = 0;       // with merged ones, until they are dropped
  uint32_t merged_count = 0;

  // The first corner around a vertex, from which swinging right meets all.
  PSPLIT_HD Index first_corner(Index vertex) const {
    const Index corner = border[vertex].corner();
    return corner == kNone<Index> ? corner : previous(corner);
  }

  // Afterwards every vertex has corners. The last vertices take the numbers of merged ones, in the order of
  // merging; or all move up, where the order of vertices must not change.
  PSPLIT_HD void drop_merged_vertices(bool keep_order) {
    if (merged_count == 0) return;
    if (keep_order) {
      // border[v].beyond is spent once the borders are: it holds the new numbers.
      uint32_t count = 0;
      for (uint32_t v = 0; v < vertex_count; ++v) {
        const Index corner = border[v].corner();
        if (corner != kNone<Index>) {
          border[count] = {corner, border[count].beyond()};
          closed[count] = closed[v];
        }
        border[v] = {border[v].corner(), static_cast<Index>(count)};
        count += corner != kNone<Index> ? 1 : 0;
      }
      for (size_t corner = 0; corner < table.vertex.size(); corner += 4)
        for (size_t k = corner; k < corner + 3; ++k) table.vertex[k] = border[table.vertex[k]].beyond();
      vertex_count = count;
      return;
    }
    for (uint32_t i = 0; i < merged_count; ++i) {
      const Index hole = merged[i];
      while (border[vertex_count - 1].corner() == kNone<Index>) --vertex_count;
      const auto last = static_cast<Index>(vertex_count - 1);
      if (last < hole) continue;
      const Index start = first_corner(last);
      Index corner = start;
      do {
        table.vertex[corner] = hole;
        corner = table.swing_right(corner);
      } while (corner != kNone<Index> && corner != start);
      border[hole] = border[last];
      closed[hole] = closed[last];
      border[last] = {kNone<Index>, 0};
      --vertex_count;
    }
  }

  PSPLIT_HD bool allocate(Arena& arena) {
    const size_t corners = corner_room(counts), vertices = vertex_room(counts);
    return arena.take(table.opposite, corners) && arena.take(table.vertex, corners) &&
           arena.take(border, vertices) && arena.take(closed, vertices) &&
           arena.take(merged, counts.symbol_count);
  }
  // The memory that allocate takes.
  PSPLIT_HD static size_t bytes(const ConnectivityCounts& counts) {
    const size_t corners = corner_room(counts), vertices = vertex_room(counts);
    return 2 * Arena::bytes<Index>(corners) + Arena::bytes<BorderEdge<Index>>(vertices) +
           Arena::bytes<bool>(vertices) + Arena::bytes<Index>(counts.symbol_count);
  }

 private:
  PSPLIT_HD static size_t corner_room(const ConnectivityCounts& counts) {
    return size_t{4} * counts.face_count;
  }
  // The last symbol may bring three vertices more than the limit before the excess is found.
  PSPLIT_HD static size_t vertex_room(const ConnectivityCounts& counts) {
    return size_t{counts.vertex_limit} + 3;
  }
};

// Handles: while the symbol `source` was decoded, an edge of its face was set aside for the S at `split`.
struct SplitEvent {
  uint32_t source = 0;  // both count in the order of decoding
  uint32_t split = 0;
  uint32_t right_edge = 0;
};

// Symbols of the standard traversal.
class StandardSymbols {
 public:
  PSPLIT_HD explicit StandardSymbols(BitReader bits) : bits_(bits) {}
  PSPLIT_HD uint32_t next(uint32_t) {
    const auto ahead = static_cast<uint32_t>(bits_.peek(3));
    const uint32_t is_long = ahead & 1;
    bits_.take(static_cast<int>(1 + 2 * is_long));
    return ahead & 7 & (0 - is_long);
  }
  PSPLIT_HD void added(uint32_t, uint32_t, uint32_t, uint32_t) {}
  PSPLIT_HD void merged(uint32_t, uint32_t) {}

 private:
  BitReader bits_;
};

// Symbols of the valence traversal: one list for each valence, so far, of the vertex that a C would close.
template <typename Valence>
class ValenceSymbols {
 public:
  static constexpr uint32_t kLowest = 2, kHighest = 7, kLists = kHighest - kLowest + 1;

  // Starts a sequence for each list, which are to be decoded before finish.
  PSPLIT_HD Fault start(ByteReader& reader, const ConnectivityCounts& counts, Arena& arena,
                        View<SymbolSequence> sequences) {
    if (!arena.take(valences_, size_t{counts.vertex_limit} + 3)) return Fault::kWorkspace;
    fill(valences_, Valence{0});
    for (uint32_t i = 0; i < kLists; ++i) {
      List& list = lists_[i];
      list.left = reader.varint();
      if (reader.truncated()) return Fault::kTruncated;
      if (list.left > counts.face_count) return Fault::kCounts;
      if (!arena.take(list.decoded, list.left)) return Fault::kWorkspace;
      sequences[i] = {};
      Fault fault = sequences[i].start(reader, list.left, 1, arena, list.decoded);
      if (fault == Fault::kNone && sequences[i].is_tagged()) {
        fault = sequences[i].finish(SerialLanes(), reader);  // the next list begins behind its last bit
        sequences[i] = {};
      }
      if (fault != Fault::kNone) return fault;
    }
    return Fault::kNone;
  }

  // The memory that `start` takes if the lists have `symbol_count` symbols together, without the sequences'
  // tables.
  PSPLIT_HD static size_t bytes(const ConnectivityCounts& counts) {
    return Arena::bytes<Valence>(uint64_t{counts.vertex_limit} + 3) +
           Arena::bytes<uint32_t>(counts.symbol_count) + (kLists - 1) * Arena::bytes<uint32_t>(0);
  }

  PSPLIT_HD Fault finish(ByteReader& reader, View<SymbolSequence> sequences) {
    for (uint32_t i = 0; i < kLists; ++i) {
      if (const Fault fault = sequences[i].finish(SerialLanes(), reader); fault != Fault::kNone) return fault;
      // A byte each, in place.
      constexpr uint8_t kClersOfSymbol[8] = {kC, kS, kL, kR, kE, kBroken, kBroken, kBroken};
      List& list = lists_[i];
      list.symbols = reinterpret_cast<uint8_t*>(list.decoded.data());
      for (uint32_t k = 0; k < list.left; ++k) {
        const uint32_t symbol = list.decoded[k];
        list.symbols[k] = symbol < 8 ? kClersOfSymbol[symbol] : kBroken;
      }
    }
    return Fault::kNone;
  }

  // `active` is the vertex that a C would close.
  PSPLIT_HD uint32_t next(uint32_t active) {
    if (active == kNone<Valence>) return kE;  // nothing is decoded yet
    const uint32_t valence = valences_[active];
    List& list = lists_[(valence < kLowest ? kLowest : valence > kHighest ? kHighest : valence) - kLowest];
    return list.left > 0 ? list.symbols[--list.left] : uint32_t{kBroken};
  }

  // The face that a symbol added, by its vertices.
  PSPLIT_HD void added(uint32_t symbol, uint32_t v0, uint32_t v1, uint32_t v2) {
    grow(v0, symbol == kE ? 2 : symbol == kL || symbol == kR ? 1 : 0);
    grow(v1, symbol == kE || symbol == kL ? 2 : 1);
    grow(v2, symbol == kE || symbol == kR ? 2 : 1);
  }
  PSPLIT_HD void merged(uint32_t into, uint32_t vertex) { grow(into, valences_[vertex]); }

 private:
  static constexpr uint8_t kBroken = 6;
  struct List {
    View<uint32_t> decoded;
    uint8_t* symbols = nullptr;
    uint32_t left = 0;
  };
  PSPLIT_HD void grow(uint32_t vertex, uint32_t by) {
    valences_[vertex] = static_cast<Valence>(valences_[vertex] + by);
  }

  List lists_[kLists];
  View<Valence> valences_;
};

// The memory that decode_connectivity takes, and gives back.
template <typename Index>
PSPLIT_HD size_t connectivity_scratch_bytes(const ConnectivityCounts& counts) {
  return (counts.split_count > 0 ? 2 : 1) * Arena::bytes<Index>(counts.symbol_count);
}

// Decodes all symbols and joins the components' first faces. On success every corner has its vertex, every pair
// of opposite corners names each other, and each vertex that is not merged has one fan of faces.
template <typename Index, typename Symbols>
PSPLIT_HD Fault decode_connectivity(Symbols symbols, View<const SplitEvent> events, RansBits& start_faces,
                                    Arena& arena, Connectivity<Index>& mesh) {
  const ConnectivityCounts counts = mesh.counts;
  if (counts.symbol_count == 0) return counts.face_count == 0 ? Fault::kNone : Fault::kCounts;
  const View<Index> opposite = mesh.table.opposite, vertex = mesh.table.vertex;
  const View<BorderEdge<Index>> border = mesh.border;
  const auto link = [&](uint32_t a, uint32_t b) {
    opposite[a] = static_cast<Index>(b);
    opposite[b] = static_cast<Index>(a);
  };
  fill(opposite, kNone<Index>);
  View<Index> stack, set_aside;
  const size_t mark = arena.mark();
  if (!arena.take(stack, counts.symbol_count)) return Fault::kWorkspace;
  if (!events.empty()) {
    if (!arena.take(set_aside, counts.symbol_count)) return Fault::kWorkspace;
    fill(set_aside, kNone<Index>);
  }
  size_t next_event = events.size();  // the last event is the first to come
  uint32_t event_symbol = next_event > 0 ? events[next_event - 1].source : ~0u;
  uint32_t vertex_count = 0, stack_size = 0;
  // The active edge lies opposite `active`, the newest face's corner 0, and runs from vertex `from` to vertex
  // `to`.
  uint32_t active = 0, from = 0, to = kNone<Index>;
  bool degenerate = false;

  for (uint32_t i = 0; i < counts.symbol_count; ++i) {
    const uint32_t symbol = symbols.next(to);
    const uint32_t c0 = 4 * i, c1 = c0 + 1, c2 = c0 + 2;
    uint32_t v0, v1, v2;  // the new face; its corner 0 sees the next active edge, from v2 to v1
    if (PSPLIT_LIKELY(is_clr(symbol))) {
      // Which of the three comes next is as good as random: all three in one, with masks for branches. R is L
      // with sides exchanged; C is L with the border's next vertex in place of a new one, and its edge b across
      // corner 2.
      if (PSPLIT_UNLIKELY(i == 0)) return Fault::kConnectivity;
      const uint32_t if_c = (symbol & 1) - 1, if_r = 0 - (symbol >> 2), fresh = vertex_count;
      // The next step waits for v1, which waits for this load: the rest is chosen before it comes.
      const BorderEdge<Index> b = border[to];
      const uint32_t unless_c = select(if_r, to, fresh) & ~if_c;
      v0 = select(if_r, from, to), v2 = select(if_r, fresh, from);
      v1 = (b.beyond() & if_c) | unless_c;
      link(active, c1 - if_r);
      // What is no C links the face's unused fourth corner, which nobody reads.
      const uint32_t unused = c0 + 3, across = select(if_c, b.corner(), unused);
      opposite[across] = static_cast<Index>(c2);
      opposite[select(if_c, c2, unused)] = static_cast<Index>(across);
      border[fresh] = {c2 + 2 * if_r, to};
      border[from] = {c0 - if_r, select(if_r, fresh, v1)};
      vertex_count += 1 + if_c;
    } else if (symbol == kS) {
      // b is the active edge; a comes from the stack, or was set aside for this very symbol.
      if (i == 0) return Fault::kConnectivity;
      uint32_t a = set_aside.empty() ? kNone<Index> : set_aside[i];
      if (a == kNone<Index>) {
        if (stack_size == 0) return Fault::kConnectivity;
        a = stack[--stack_size];
      }
      const uint32_t p = vertex[previous(a)], n = to;
      if (a == active || opposite[a] != kNone<Index> || p == n) return Fault::kConnectivity;
      v0 = p, v1 = vertex[next(a)], v2 = from;
      symbols.merged(p, n);
      for (Index at = static_cast<Index>(next(active)); at != kNone<Index>; at = mesh.table.swing_left(at)) {
        if (vertex[at] == p) return Fault::kConnectivity;
        vertex[at] = static_cast<Index>(p);
      }
      link(a, c2);
      link(active, c1);
      border[p] = border[n];
      border[n] = {kNone<Index>, 0};
      mesh.merged[mesh.merged_count++] = static_cast<Index>(n);
      border[from] = {c0, v1};
    } else if (symbol == kE) {
      if (i > 0) stack[stack_size++] = static_cast<Index>(active);
      v0 = vertex_count, v1 = v0 + 1, v2 = v0 + 2;
      vertex_count += 3;
      border[v0] = {c1, v2};
      border[v1] = {c2, v0};
      border[v2] = {c0, v1};
    } else {
      return Fault::kConnectivity;
    }
    if (PSPLIT_UNLIKELY(vertex_count > counts.vertex_limit)) return Fault::kCounts;
    degenerate |= v1 == v2;
    vertex[c0] = static_cast<Index>(v0), vertex[c1] = static_cast<Index>(v1),
    vertex[c2] = static_cast<Index>(v2);
    active = c0, from = v2, to = v1;
    symbols.added(symbol, v0, v1, v2);
    if (PSPLIT_UNLIKELY(i == event_symbol)) {
      // Only symbols that bring a vertex have events.
      if (symbol == kC || symbol == kS) return Fault::kSplitEvent;
      for (; next_event > 0 && events[next_event - 1].source == i; --next_event) {
        const SplitEvent& event = events[next_event - 1];
        if (event.split > i) set_aside[event.split] = static_cast<Index>(event.right_edge != 0 ? c1 : c2);
      }
      event_symbol = next_event > 0 ? events[next_event - 1].source : ~0u;
      if (event_symbol <= i) return Fault::kSplitEvent;
    }
  }
  if (next_event > 0) return Fault::kSplitEvent;
  if (degenerate) return Fault::kConnectivity;

  // Every border that is left was one of an encoded component's: either open, or a hole in the shape of a face.
  stack[stack_size++] = static_cast<Index>(active);
  uint32_t face_count = counts.symbol_count;
  while (stack_size > 0) {
    const uint32_t a = stack[--stack_size];
    if (!start_faces.next()) continue;
    if (face_count == counts.face_count) return Fault::kCounts;
    const uint32_t n = vertex[next(a)], b = border[n].corner();
    if (opposite[a] != kNone<Index> || b == kNone<Index> || b == a || opposite[b] != kNone<Index>)
      return Fault::kConnectivity;
    const uint32_t x = vertex[next(b)], c = border[x].corner();
    if (c == kNone<Index> || c == a || c == b || opposite[c] != kNone<Index>) return Fault::kConnectivity;
    const uint32_t p = vertex[next(c)], c0 = 4 * face_count;
    if (p != vertex[previous(a)]) return Fault::kConnectivity;
    link(a, c0);
    link(b, c0 + 1);
    link(c, c0 + 2);
    vertex[c0] = static_cast<Index>(x), vertex[c0 + 1] = static_cast<Index>(p),
    vertex[c0 + 2] = static_cast<Index>(n);
    ++face_count;
  }
  if (face_count != counts.face_count) return Fault::kCounts;
  mesh.vertex_count = vertex_count;
  for (uint32_t v = 0; v < vertex_count; ++v) {
    const uint32_t corner = border[v].corner();
    mesh.closed[v] = corner != kNone<Index> && opposite[corner] != kNone<Index>;
  }
  arena.release(mark);
  return Fault::kNone;
}

}  // namespace psplit::core
