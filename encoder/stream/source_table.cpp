#include "encoder/stream/source_table.h"

#include <utility>
#include <vector>

namespace psplit {
namespace {

// The edges that leave a vertex, in the order of their faces. An edge is given by the corner across from it.
struct LeavingEdge {
  uint32_t to;
  uint32_t corner;  // kLinked behind the first face that comes the other way
};
constexpr uint32_t kLinked = ~uint32_t{0};

// The part of the array of edges that a vertex has.
struct EdgeList {
  uint32_t begin = 0, end = 0;
};

bool is_flat(const SourceTable::Face& face) {
  const uint32_t* const v = face.vertex;
  return v[0] == v[1] || v[0] == v[2] || v[1] == v[2];
}

}  // namespace

SourceTable::SourceTable(std::span<const std::array<uint32_t, 3>> faces,
                         std::span<const uint32_t> vertex_of_point, uint32_t vertex_limit)
    : face_count_(static_cast<uint32_t>(faces.size())), faces_(new Face[faces.size() + 1]) {
  const uint32_t none = no_corner();
  for (size_t i = 0; i < faces.size(); ++i) {
    Face& face = faces_[i];
    face = {{}, Face::kUnseen, {none, none, none}, 0};
    for (int k = 0; k < 3; ++k) face.vertex[k] = vertex_of_point[faces[i][static_cast<size_t>(k)]];
    if (!is_flat(face)) continue;
    ++flat_count_;
    face.mark = Face::kSeen;
    face.fans_seen = 0b111;
  }
  faces_[face_count_] = {{}, Face::kSeen, {none, none, none}, 0b111};
  if (const std::vector<bool> may_fold = link_faces(vertex_limit); !may_fold.empty()) break_folds(may_fold);
  separate_fans(vertex_limit);
}

// Links each edge to the first edge that runs the other way, is not linked yet, and does not belong to the same
// face upside down. Returns the vertices whose fans may have folds: the ends of edges that have more faces than
// the two that are linked there. Empty if there are none.
std::vector<bool> SourceTable::link_faces(uint32_t vertex_limit) {
  std::vector<EdgeList> lists(vertex_limit);
  for (uint32_t i = 0; i < face_count_; ++i)
    if (faces_[i].mark == Face::kUnseen)
      for (const uint32_t vertex : faces_[i].vertex) ++lists[vertex].end;
  uint32_t edge_count = 0;
  for (EdgeList& list : lists) {
    const uint32_t count = list.end;
    list = {edge_count, edge_count};
    edge_count += count;
  }
  const std::unique_ptr<LeavingEdge[]> edges(new LeavingEdge[edge_count]);
  std::vector<bool> may_fold;
  const auto note_fold = [&](uint32_t from, uint32_t to) {
    may_fold.resize(vertex_limit);
    may_fold[from] = may_fold[to] = true;
  };
  for (uint32_t i = 0; i < face_count_; ++i) {
    Face& face = faces_[i];
    if (face.mark != Face::kUnseen) continue;
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t corner = 4 * i + k, from = face.vertex[core::next(k)], to = face.vertex[core::previous(k)];
      const EdgeList back = lists[to];
      uint32_t at = back.begin;
      for (; at < back.end; ++at) {
        if (edges[at].to != from) continue;
        if (edges[at].corner != kLinked && vertex(edges[at].corner) != face.vertex[k]) break;
        note_fold(from, to);
      }
      if (at < back.end) {
        const uint32_t across = std::exchange(edges[at].corner, kLinked);
        face.opposite[k] = across;
        this->face(across).opposite[across & 3] = corner;
        continue;
      }
      EdgeList& list = lists[from];
      for (uint32_t other = list.begin; other < list.end; ++other)
        if (edges[other].to == to) note_fold(from, to);
      edges[list.end++] = {to, corner};
    }
  }
  return may_fold;
}

void SourceTable::unlink(uint32_t corner) {
  uint32_t& across = face(corner).opposite[corner & 3];
  if (across == no_corner()) return;
  face(across).opposite[across & 3] = no_corner();
  across = no_corner();
}

// Walks clockwise around each vertex that may have a fold. If the edge ahead was passed before, both are
// unlinked, and the rest of the fan is left for later: its faces may have become other fans. The result depends
// on the order.
void SourceTable::break_folds(const std::vector<bool>& may_fold) {
  // An edge that was passed: the vertex at its other end, and the corner across from it.
  struct Edge {
    uint32_t to, corner;
  };
  std::vector<Edge> passed;
  std::vector<uint32_t> corners;  // of these vertices
  for (uint32_t corner = 0; corner < no_corner(); ++corner)
    if ((corner & 3) != 3 && face(corner).mark == Face::kUnseen && may_fold[vertex(corner)])
      corners.push_back(corner);
  std::vector<bool> seen(size_t{4} * face_count_);
  // Walks on from `first`. Returns whether links were broken.
  const auto walk = [&](uint32_t first) {
    passed.clear();
    uint32_t at = first;
    do {
      seen[at] = true;
      const uint32_t to = vertex(core::next(at)), corner = core::previous(at);
      for (const Edge& edge : passed) {
        // The walk comes back to where it began.
        if (edge.to != to || opposite(corner) == edge.corner) continue;
        unlink(corner);
        unlink(edge.corner);
        return true;
      }
      passed.push_back({vertex(core::previous(at)), core::next(at)});
      at = swing_right(at);
    } while (at != first && at != no_corner());
    return false;
  };
  for (bool broken = true; std::exchange(broken, false);)
    for (const uint32_t corner : corners) {
      if (seen[corner]) continue;
      uint32_t first = corner;
      for (uint32_t left = swing_left(first); left != corner && left != no_corner() && !seen[left];
           left = swing_left(first))
        first = left;
      broken |= walk(first);
    }
}

// The first fan of a vertex keeps its number.
void SourceTable::separate_fans(uint32_t vertex_limit) {
  std::vector<bool> has_fan(vertex_limit);
  // Each vertex has a corner, so that this is room for all fans.
  states_.reset(new VertexState[size_t{vertex_limit} + size_t{3} * face_count_]);
  uint32_t next_number = vertex_limit;
  for (uint32_t i = 0; i < face_count_; ++i)
    for (uint32_t k = 0; k < 3; ++k) {
      if ((faces_[i].fans_seen >> k & 1) != 0) continue;
      const uint32_t corner = 4 * i + k, shared = faces_[i].vertex[k];
      const uint32_t number = has_fan[shared] ? next_number++ : shared;
      has_fan[shared] = true;
      ++vertex_count_;
      const auto see = [&](uint32_t at) {
        face(at).fans_seen |= 1u << (at & 3);
        face(at).vertex[at & 3] = number;
      };
      uint32_t at = corner;
      do {
        see(at);
        at = swing_left(at);
      } while (at != corner && at != no_corner());
      states_[number] = at == no_corner() ? kBorder : kInside;
      if (at == no_corner())
        for (at = swing_right(corner); at != no_corner(); at = swing_right(at)) see(at);
    }
}

}  // namespace psplit
