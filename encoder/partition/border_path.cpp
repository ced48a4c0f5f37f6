#include "encoder/partition/border_path.h"

#include <algorithm>
#include <cstdlib>

namespace psplit {
namespace {

constexpr uint32_t next(uint32_t k) { return k == 2 ? 0 : k + 1; }
constexpr uint32_t previous(uint32_t k) { return k == 0 ? 2 : k - 1; }

}  // namespace

uint32_t BorderPath::to(Side side) const { return graph_.faces[side.face].vertices[next(side.side)]; }

uint32_t BorderPath::other_end(Side side, uint32_t vertex) const {
  return from(side) == vertex ? to(side) : from(side);
}

uint32_t BorderPath::corner_of(uint32_t face, uint32_t vertex) const {
  const auto& vertices = graph_.faces[face].vertices;
  const bool is_not_0 = vertices[0] != vertex, is_not_1 = vertices[1] != vertex;
  return static_cast<uint32_t>(is_not_0) + static_cast<uint32_t>(is_not_0 & is_not_1);  // no branch to guess
}

// The same edge as the face on its other side has it, where that one is linked here as well; else of no face.
BorderPath::Side BorderPath::across(Side side, uint32_t vertex) const {
  const uint32_t face = neighbour(side);
  if (face == kNoCell) return {};
  const uint32_t corner = corner_of(face, vertex);
  const bool is_ahead = graph_.faces[face].vertices[next(corner)] == other_end(side, vertex);
  const Side other{face, is_ahead ? corner : previous(corner)};
  return neighbour(other) == side.face ? other : Side{};
}

// Whether both faces of an edge are regular, and know each other.
bool BorderPath::is_plain(Side side) const {
  const uint32_t behind = across(side, from(side)).face;
  return behind != kNone && !graph_.is_irregular(side.face) && !graph_.is_irregular(behind);
}

// Turns around a vertex: through the side's face to its other side there, on to the next face, and so on while
// visit(side, face behind it) says so, which is asked at every side before it is crossed. Returns the side at
// which it stopped, of the face before it; a side of no face where it came round.
template <typename Visit>
BorderPath::Side BorderPath::turn(Side side, uint32_t vertex, Visit visit) const {
  constexpr int kMostFaces = 1 << 12;  // what is no fan is left alone
  Side at = side;
  for (int i = 0; i < kMostFaces; ++i) {
    const uint32_t corner = corner_of(at.face, vertex);
    const Side out{at.face, at.side == corner ? previous(corner) : corner};
    at = across(out, vertex);
    if (!visit(out, at.face)) return out;
    if (at == side) break;
  }
  return {};
}

BorderPath::Side BorderPath::turn_within(Side side, uint32_t vertex, uint32_t patch) const {
  return turn(side, vertex, [&](Side, uint32_t behind) { return is_in(behind, patch); });
}

// Whether it was marked before.
bool BorderPath::mark(uint32_t face, uint32_t bit) {
  const bool was_marked = is_marked(face, bit);
  if (marks_[face] >> kMarkBits != mark_stamp_) marks_[face] = mark_stamp_ << kMarkBits;
  marks_[face] |= bit;
  return was_marked;
}

bool BorderPath::trace(uint32_t a, uint32_t b, std::span<const uint32_t> border_faces) {
  a_ = a;
  b_ = b;
  sides_.clear();
  chains_.clear();
  ++mark_stamp_;
  for (const uint32_t face : border_faces) {
    if (patch_of(face) != a) continue;
    for (uint32_t side = 0; side < 3; ++side)
      if (is_in(graph_.faces[face].neighbours[side], b) && !is_marked(face, 1u << side) &&
          (!is_plain({face, side}) || !trace_from({face, side})))
        return false;
  }
  return true;
}

// To the next side of the border, or the one before; to a side of no face where it ends. False where faces
// disagree.
bool BorderPath::step(Side& side, bool is_forward) const {
  const uint32_t vertex = is_forward ? to(side) : from(side);
  side = turn_within(side, vertex, a_);
  if (side.face == kNone) return false;
  if (is_in(neighbour(side), b_)) return is_plain(side) && (is_forward ? from(side) : to(side)) == vertex;
  side = {};
  return true;
}

bool BorderPath::trace_from(Side start) {
  const auto first = static_cast<uint32_t>(sides_.size());
  const auto follow = [&](bool is_forward) {
    for (Side at = start; step(at, is_forward);) {
      if (at.face == kNone) return true;
      if (mark(at.face, 1u << at.side)) return false;  // round in a circle
      sides_.push_back(at);
    }
    return false;
  };
  mark(start.face, 1u << start.side);
  if (!follow(false)) return false;
  std::reverse(sides_.begin() + first, sides_.end());
  sides_.push_back(start);
  if (!follow(true)) return false;
  chains_.push_back({first, static_cast<uint32_t>(sides_.size())});
  return true;
}

// Its place in vertices_, null where it is not there.
uint32_t* BorderPath::find_place(uint32_t vertex) {
  uint32_t& place = place_[vertex];
  return place < vertices_.size() && vertices_[place].vertex == vertex ? &place : nullptr;
}

uint32_t BorderPath::add(uint32_t vertex, uint32_t face, int depth, Kind kind) {
  place_[vertex] = static_cast<uint32_t>(vertices_.size());
  Vertex& added = vertices_.emplace_back();
  added.vertex = vertex;
  added.face = face;
  added.depth = depth;
  added.kind = kind;
  return place_[vertex];
}

// Adds the vertices along the rim from an end of the chain, past the faces of one patch.
void BorderPath::walk_rim(Side side, uint32_t vertex, int most, int step, Kind kind) {
  const uint32_t own = patch_of(side.face);
  for (int depth = 0;; ++depth) {
    const Side ahead = turn_within(side, vertex, own);
    if (ahead.face == kNone || is_in(neighbour(ahead), a_) || is_in(neighbour(ahead), b_)) return;
    if (depth > 0) add(vertex, side.face, depth * step, kind);
    vertex = other_end(ahead, vertex);
    if (depth == most || find_place(vertex) != nullptr) return;
    side = ahead;
  }
}

void BorderPath::look_around(const Chain& chain, int into_a, int into_b) {
  vertices_.clear();
  arcs_.clear();
  const std::span<const Side> sides = std::span(sides_).subspan(chain.first, chain.length());
  const Side first = sides.front(), last = sides.back();
  add(from(first), first.face, 0, Kind::kSource);
  for (const Side& side : sides.subspan(1))
    if (find_place(from(side)) == nullptr) add(from(side), side.face, 0, Kind::kInside);
  for (Vertex& vertex : vertices_) vertex.is_on_chain = true;
  if (find_place(to(last)) != nullptr) return vertices_.clear();  // it ends where it has been
  vertices_[add(to(last), last.face, 0, Kind::kTarget)].is_on_chain = true;
  const auto on_chain = static_cast<uint32_t>(vertices_.size());
  walk_rim(first, from(first), into_a, 1, Kind::kSource);
  walk_rim(across(first, from(first)), from(first), into_b, -1, Kind::kSource);
  walk_rim(last, to(last), into_a, 1, Kind::kTarget);
  walk_rim(across(last, to(last)), to(last), into_b, -1, Kind::kTarget);
  // The nearest first; the rest of the rim when all are known that it leads to.
  const auto rim_end = static_cast<uint32_t>(vertices_.size());
  for (uint32_t i = 0; i < on_chain; ++i) expand(i, into_a, into_b);
  for (uint32_t i = rim_end; i < vertices_.size(); ++i) expand(i, into_a, into_b);
  for (uint32_t i = on_chain; i < rim_end; ++i) expand(i, 0, 0);
}

// Finds the edges of a vertex that a path may take, and adds the vertices that they lead to.
void BorderPath::expand(uint32_t index, int into_a, int into_b) {
  const auto first_arc = static_cast<uint32_t>(arcs_.size());
  Vertex here = vertices_[index];
  const uint32_t vertex = here.vertex;
  bool is_in_a = false, is_in_b = false, is_barred = false;
  const auto visit = [&](Side side, uint32_t other) {
    const uint32_t patch = patch_of(side.face);
    is_in_a |= patch == a_;
    is_in_b |= patch == b_;
    is_barred |= graph_.is_irregular(side.face);
    // The face behind this one will be wanted when the vertices are expanded that are added now: memory is
    // slow.
    const uint32_t behind = graph_.faces[side.face].neighbours[next(corner_of(side.face, vertex))];
    if (behind != kNoCell) __builtin_prefetch(&graph_.faces[behind]);
    if (!is_in(other, a_) && !is_in(other, b_)) return false;
    const uint32_t end = other_end(side, vertex);
    if (const uint32_t* place = find_place(end); place != nullptr) {
      arcs_.push_back({*place, side});
    } else if (patch == patch_of(other)) {  // else it is on another stretch of border
      const int end_depth = patch == a_ ? here.depth + 1 : here.depth - 1;
      if (end_depth <= into_a && -end_depth <= into_b)
        arcs_.push_back({add(end, side.face, end_depth, Kind::kInside), side});
    }
    return true;
  };
  const uint32_t corner = corner_of(here.face, vertex);
  const bool is_round = turn({here.face, previous(corner)}, vertex, visit).face == kNone;
  if (here.kind == Kind::kInside)
    is_barred |= !is_round || (is_in_a && is_in_b && !here.is_on_chain);
  else if (!is_round)
    turn({here.face, corner}, vertex, visit);
  if (is_barred) {
    here.kind = Kind::kBarred;
    arcs_.resize(first_arc);
  }
  here.first_arc = first_arc;
  here.end_arc = static_cast<uint32_t>(arcs_.size());
  vertices_[index] = here;
}

uint32_t BorderPath::find(int least, int most, Preference preference) {
  queue_.clear();
  path_.clear();
  for (uint32_t i = 0; i < vertices_.size(); ++i) {
    Vertex& vertex = vertices_[i];
    const bool is_within = vertex.depth >= least && vertex.depth <= most && vertex.kind != Kind::kBarred;
    vertex.distance = is_within ? kNone : kNone - 1;
    if (!is_within || vertex.kind != Kind::kSource) continue;
    vertex.distance = 0;
    queue_.push_back(i);
  }
  uint32_t length = kNone;
  for (size_t i = 0; i < queue_.size() && vertices_[queue_[i]].distance < length; ++i) {
    const Vertex& here = vertices_[queue_[i]];
    for (uint32_t k = here.first_arc; k < here.end_arc; ++k) {
      Vertex& there = vertices_[arcs_[k].to];
      if (there.distance != kNone) continue;
      there.distance = here.distance + 1;
      if (there.kind == Kind::kTarget)
        length = there.distance;
      else
        queue_.push_back(arcs_[k].to);
    }
  }
  if (length == kNone) return 0;
  const auto cost = [&](uint32_t i) {
    const int depth = vertices_[i].depth;
    return preference == Preference::kNearest ? std::abs(depth)
           : preference == Preference::kIntoA ? -depth
                                              : depth;
  };
  uint32_t at = kNone;
  for (uint32_t i = 0; i < vertices_.size(); ++i)
    if (vertices_[i].kind == Kind::kTarget && vertices_[i].distance == length &&
        (at == kNone || cost(i) < cost(at)))
      at = i;
  while (vertices_[at].distance > 0) {
    const Vertex& here = vertices_[at];
    uint32_t best = kNone;
    for (uint32_t k = here.first_arc; k < here.end_arc; ++k) {
      const Vertex& there = vertices_[arcs_[k].to];
      if (there.distance + 1 == here.distance && there.kind != Kind::kTarget &&
          (best == kNone || cost(arcs_[k].to) < cost(arcs_[best].to)))
        best = k;
    }
    if (best == kNone) return 0;  // an edge that only one of its ends has
    at = arcs_[best].to;
    const Side side = arcs_[best].side;
    path_.push_back(from(side) == vertices_[at].vertex ? side : across(side, from(side)));
  }
  std::reverse(path_.begin(), path_.end());
  return length;
}

bool BorderPath::divide() {
  to_a_.clear();
  to_b_.clear();
  ++mark_stamp_;
  for (const Side& side : path_) {
    const Side other = across(side, from(side));
    mark(side.face, 1u << side.side);
    mark(other.face, 1u << other.side);
  }
  for (const Side& side : path_) {
    const uint32_t left = side.face, right = neighbour(side);
    if (patch_of(left) == b_ && !mark(left, kMoved)) to_a_.push_back(left);
    if (patch_of(right) == a_ && !mark(right, kMoved)) to_b_.push_back(right);
  }
  return flood(to_a_, b_) && flood(to_b_, a_);
}

// Adds the other faces up to path and border.
bool BorderPath::flood(std::vector<uint32_t>& moved, uint32_t from) {
  for (size_t i = 0; i < moved.size(); ++i) {
    const uint32_t face = moved[i];
    if (graph_.is_irregular(face)) return false;
    for (uint32_t side = 0; side < 3; ++side) {
      const uint32_t other = graph_.faces[face].neighbours[side];
      if (!is_marked(face, 1u << side) && is_in(other, from) && !mark(other, kMoved)) moved.push_back(other);
    }
  }
  return true;
}

bool BorderPath::apply() {
  const auto move = [&](uint32_t a, uint32_t b) {
    for (const uint32_t face : to_a_) store_shared(patch_of_[face], a);
    for (const uint32_t face : to_b_) store_shared(patch_of_[face], b);
  };
  move(a_, b_);
  if (is_divided()) return true;
  move(b_, a_);
  return false;
}

// Whether all faces along the path are in a on its left and in b on its right, around its vertices as well, and
// what was moved touches what it was moved to. Then either side of the path is connected, and with it all of
// each patch: what is left of one was parted by what was taken, which ends at the path.
bool BorderPath::is_divided() const {
  const auto is_joined = [&](std::span<const uint32_t> moved, uint32_t patch) {
    return moved.empty() || std::any_of(moved.begin(), moved.end(), [&](uint32_t face) {
             for (uint32_t side = 0; side < 3; ++side) {
               const uint32_t other = graph_.faces[face].neighbours[side];
               if (!is_marked(face, 1u << side) && is_in(other, patch) && !is_marked(other, kMoved))
                 return true;
             }
             return false;
           });
  };
  if (!is_joined(to_a_, a_) || !is_joined(to_b_, b_)) return false;
  for (size_t i = 0; i < path_.size(); ++i) {
    const Side left = path_[i];
    if (patch_of(left.face) != a_ || !is_in(neighbour(left), b_)) return false;
    if (i == 0) continue;
    const uint32_t vertex = other_end(left, to(left));
    const Side before = path_[i - 1];
    if (turn_within(left, vertex, a_) != before) return false;
    if (turn_within(across(left, vertex), vertex, b_) != across(before, vertex)) return false;
  }
  return true;
}

}  // namespace psplit
