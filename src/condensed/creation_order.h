// The order in which Edgebreaker creates the vertices of an attribute's table, and the prediction of values in
// that order. Specification: "order of creation".
#pragma once

#include <span>
#include <vector>

#include "src/core/corner_table.h"

namespace psplit {

// Forward: faces in their order, corners 0, 1 and 2 of each. Backward: faces from the last to the first,
// corners 1, 2 and 0 of each. A vertex that has not occurred comes next.
// Known vertices come before all others.
struct CreationOrder {
  std::vector<uint32_t> vertex;  // in the order
  std::vector<uint32_t> corner;  // where each vertex occurred first; any corner of a known vertex
  std::vector<uint32_t> rank;    // by vertex: its place in the order
  uint32_t known_count = 0;

  // `known` names each vertex at most once.
  CreationOrder(const core::CornerTable<uint32_t>& table, uint32_t vertex_count, bool backward,
                std::span<const uint32_t> known)
      : vertex(known.begin(), known.end()),
        corner(known.size()),
        rank(vertex_count, core::kNone<uint32_t>),
        known_count(static_cast<uint32_t>(known.size())) {
    vertex.reserve(vertex_count);
    corner.reserve(vertex_count);
    for (uint32_t i = 0; i < known_count; ++i) rank[known[i]] = i;
    const auto face_count = static_cast<uint32_t>(table.vertex.size() / 4);
    for (uint32_t i = 0; i < face_count; ++i) {
      const uint32_t first = backward ? 4 * (face_count - 1 - i) + 1 : 4 * i;
      for (uint32_t c : {first, core::next(first), core::previous(first)}) {
        uint32_t& at = rank[table.vertex[c]];
        if (at != core::kNone<uint32_t>) continue;
        at = static_cast<uint32_t>(corner.size());
        vertex.push_back(table.vertex[c]);
        corner.push_back(c);
      }
    }
  }
};

// Predicts values that are stored in the order of creation. The answers are ranks, which all components share.
class CreationPredictor {
 public:
  struct Parallelogram {
    uint32_t a = 0, b = 0, far = 0;  // predicts a + b - far
  };
  // Two parallelograms, or one, or none; then `edge` has the neighbours that come before, if any do.
  struct Prediction {
    uint32_t parallelogram_count = 0, edge_count = 0;
    Parallelogram parallelogram[2];
    uint32_t edge[2] = {};
    // The value that was stored last, if any was.
    bool has_last = false;
    uint32_t last = 0;
  };

  CreationPredictor(const core::CornerTable<uint32_t>& table, const CreationOrder& order, bool two)
      : table_(table), order_(order), two_(two) {}

  Prediction of(uint32_t i) const {
    Prediction found;
    const uint32_t corner = order_.corner[i];
    look(i, corner, found);
    if (two_) {
      look(i, table_.swing_left(corner), found);
      if (found.parallelogram_count < 2) look(i, table_.swing_right(corner), found);
    }
    if (found.parallelogram_count > 0) return found;
    for (const uint32_t neighbour : {rank_at(core::next(corner)), rank_at(core::previous(corner))})
      if (neighbour < i) found.edge[found.edge_count++] = neighbour;
    found.has_last = i > order_.known_count;
    found.last = i - 1;
    return found;
  }

 private:
  uint32_t rank_at(uint32_t corner) const { return order_.rank[table_.vertex[corner]]; }
  void look(uint32_t i, uint32_t corner, Prediction& found) const {
    if (corner == core::kNone<uint32_t>) return;
    const uint32_t across = table_.opposite[corner];
    if (across == core::kNone<uint32_t>) return;
    const Parallelogram p{rank_at(core::next(corner)), rank_at(core::previous(corner)), rank_at(across)};
    if (p.a < i && p.b < i && p.far < i) found.parallelogram[found.parallelogram_count++] = p;
  }

  const core::CornerTable<uint32_t>& table_;
  const CreationOrder& order_;
  bool two_;
};

// The predicted number of one component. value(rank) returns the number of an earlier value. With `reach`,
// parallelograms do not reach out as far.
template <typename Value>
int32_t predicted_number(const CreationPredictor::Prediction& by, bool mean, uint32_t reach, Value value) {
  const auto number = [&](uint32_t rank) { return static_cast<uint32_t>(value(rank)); };
  // All sums are modulo 2^32.
  const auto shifted = [](uint32_t x, uint32_t shift) {
    return static_cast<uint32_t>(static_cast<int32_t>(x) >> shift);
  };
  const auto halfway = [&](uint32_t p, uint32_t q) { return p + shifted(q - p, 1); };
  const auto completed = [&](const CreationPredictor::Parallelogram& on) {
    const uint32_t a = number(on.a), b = number(on.b), p = a + b - number(on.far);
    return reach == 0 ? p : p - shifted(p - halfway(a, b), reach);
  };
  if (by.parallelogram_count == 2)
    return static_cast<int32_t>(halfway(completed(by.parallelogram[0]), completed(by.parallelogram[1])));
  if (by.parallelogram_count == 1) return static_cast<int32_t>(completed(by.parallelogram[0]));
  if (by.edge_count == 2 && mean) return static_cast<int32_t>(halfway(number(by.edge[0]), number(by.edge[1])));
  if (by.edge_count > 0) return static_cast<int32_t>(number(by.edge[0]));
  return by.has_last ? value(by.last) : 0;
}

}  // namespace psplit
