#include "encoder/stream/traverse_faces.h"

#include <algorithm>

namespace psplit {
namespace {

using Face = SourceTable::Face;
using core::next, core::previous;

class FaceWalk {
 public:
  explicit FaceWalk(SourceTable& table) : table_(table), face_count_(table.face_count() - table.flat_count()) {
    out_.symbols.resize(face_count_);
    out_.corners.resize(face_count_);
  }

  Traversal walk_all() {
    std::vector<uint32_t> start_corners;
    for (uint32_t first = 0; first < table_.no_corner(); first += 4) {
      if (table_.face(first).mark != Face::kUnseen) continue;
      const uint32_t edge = find_border(first);
      out_.start_faces.push_back(edge == kNoBorder ? 1 : 0);
      if (edge == kNoBorder) {
        Face& face = table_.face(first);
        face.mark = Face::kSeen;
        for (const uint32_t vertex : face.vertex) table_.state(vertex) = SourceTable::kMet;
        start_corners.push_back(next(first));
        walk(table_.opposite(next(first)));
      } else {
        meet_border(edge);
        walk(edge);
      }
    }
    finish(start_corners);
    return std::move(out_);
  }

 private:
  static constexpr uint32_t kNoBorder = ~uint32_t{0};

  // The corner across from an edge of the border at which the walk begins, if the face touches the border.
  uint32_t find_border(uint32_t first) {
    const Face& face = table_.face(first);
    for (uint32_t k = 0; k < 3; ++k) {
      if (face.opposite[k] == table_.no_corner()) return first + k;
      if (table_.state(face.vertex[k]) != SourceTable::kBorder) continue;
      uint32_t last = first + k;
      for (uint32_t right = last; right != table_.no_corner(); right = table_.swing_right(right)) last = right;
      return previous(last);
    }
    return kNoBorder;
  }

  // Marks the vertices of the hole that has the edge across from `edge`.
  void meet_border(uint32_t edge) {
    uint32_t at = edge;
    do {
      table_.state(table_.vertex(previous(at))) = SourceTable::kMet;
      at = next(at);
      for (uint32_t across; (across = table_.opposite(at)) != table_.no_corner();) at = next(across);
    } while (at != edge);
  }
  // As above, for the hole at a corner's vertex.
  void meet_hole(uint32_t corner) {
    uint32_t last = corner;
    for (uint32_t left; (left = table_.swing_left(last)) != table_.no_corner();) last = left;
    meet_border(next(last));
  }

  void walk(uint32_t corner) {
    waiting_.assign(1, corner);
    while (!waiting_.empty()) {
      corner = waiting_.back();
      if (table_.face(corner).mark != Face::kUnseen)
        waiting_.pop_back();
      else
        walk_on(corner);
    }
  }

  // Goes on up to an S or E. A C is most likely, and needs nothing of the faces beside it.
  void walk_on(uint32_t corner) {
    uint8_t* const symbols = out_.symbols.data();
    uint32_t* const corners = out_.corners.data();
    for (;;) {
      const uint32_t id = count_++;
      Face& face = table_.face(corner);
      const uint32_t k = corner & 3, right = face.opposite[next(k)], left = face.opposite[previous(k)];
      SourceTable::VertexState& state = table_.state(face.vertex[k]);
      face.mark = Face::kSeen;
      corners[id] = corner;
      if (state == SourceTable::kInside) {
        state = SourceTable::kMet;
        symbols[id] = core::kC;
        corner = right;
        continue;
      }
      const uint32_t right_mark = table_.face(right).mark, left_mark = table_.face(left).mark;
      if (right_mark != Face::kUnseen) note_split(id, right_mark, 1);
      if (left_mark != Face::kUnseen) note_split(id, left_mark, 0);
      if (right_mark != Face::kUnseen && left_mark != Face::kUnseen) {
        symbols[id] = core::kE;
        waiting_.pop_back();
        return;
      }
      if (right_mark != Face::kUnseen) {
        symbols[id] = core::kR;
        corner = left;
      } else if (left_mark != Face::kUnseen) {
        symbols[id] = core::kL;
        corner = right;
      } else {
        symbols[id] = core::kS;
        if (state == SourceTable::kBorder) meet_hole(corner);
        face.mark = Face::kSplit + id;
        waiting_.back() = left;
        waiting_.push_back(right);
        return;
      }
    }
  }

  void note_split(uint32_t id, uint32_t mark, uint32_t right_edge) {
    if (mark >= Face::kSplit) out_.split_events.push_back({id, mark - Face::kSplit, right_edge});
  }

  // Turns the results from the encoder's order to the decoder's.
  void finish(const std::vector<uint32_t>& start_corners) {
    out_.symbols.resize(count_);
    std::ranges::reverse(out_.symbols);
    std::reverse(out_.corners.begin(), out_.corners.begin() + count_);
    std::ranges::copy(start_corners, out_.corners.begin() + count_);
    for (core::SplitEvent& event : out_.split_events)
      event = {count_ - 1 - event.source, count_ - 1 - event.split, event.right_edge};
  }

  SourceTable& table_;
  uint32_t face_count_, count_ = 0;
  std::vector<uint32_t> waiting_;  // corners of faces to go on at
  Traversal out_;
};

}  // namespace

Traversal traverse_faces(SourceTable& table) { return FaceWalk(table).walk_all(); }

}  // namespace psplit
