// The corner table of a mesh that is to be encoded. It has the links and vertices that libdraco's encoder
// finds, which decide about the bytes of the stream wherever the faces do not form a manifold.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/core/corner_table.h"

namespace psplit {

// Corners are numbered as in src/core/corner_table.h: 4 * face + k. Three steps make the table:
//
//   link_faces       two faces that have an edge in opposite directions are linked there
//   break_folds      a fan of faces around a vertex has each edge once: others are unlinked
//   separate_fans    each fan has a vertex of its own
//
// Faces that use a vertex twice are flat: they have no links, and are marked as encoded.
class SourceTable {
 public:
  // All that the encoder needs of a face, in half a cache line.
  struct Face {
    static constexpr uint32_t kUnseen = 0, kSeen = 1, kSplit = 2;

    uint32_t vertex[3];
    uint32_t mark;         // kUnseen, kSeen, or if an S encodes the face, kSplit and the number of its symbol
    uint32_t opposite[3];  // the corner across each edge, or no_corner()
    uint32_t fans_seen;    // while fans are separated: bit k if corner k is done
  };

  // What the encoder knows about a vertex.
  enum VertexState : uint8_t { kInside, kBorder, kMet };

  // `vertex_of_point` has numbers below `vertex_limit` for the points of the faces. Faces number fewer than
  // core::kMaxFaces. `neighbours` come from a PatchMesh, or are empty. Points with one number have one
  // position.
  SourceTable(std::span<const std::array<uint32_t, 3>> faces, std::span<const uint32_t> vertex_of_point,
              uint32_t vertex_limit, std::span<const std::array<uint32_t, 3>> neighbours);

  uint32_t face_count() const { return face_count_; }  // with flat ones
  uint32_t flat_count() const { return flat_count_; }
  uint32_t vertex_count() const { return vertex_count_; }  // of faces that are not flat

  // Stands for the corner across from an edge of the border. Its face exists, and is always seen.
  uint32_t no_corner() const { return 4 * face_count_; }
  Face& face(uint32_t corner) { return faces_[corner >> 2]; }
  const Face& face(uint32_t corner) const { return faces_[corner >> 2]; }
  uint32_t vertex(uint32_t corner) const { return face(corner).vertex[corner & 3]; }
  uint32_t opposite(uint32_t corner) const { return face(corner).opposite[corner & 3]; }
  VertexState& state(uint32_t vertex) { return states_[vertex]; }

  // As in core::CornerTable, but no_corner() at a border.
  uint32_t swing_left(uint32_t corner) const {
    const uint32_t across = opposite(core::next(corner));
    return across == no_corner() ? across : core::next(across);
  }
  uint32_t swing_right(uint32_t corner) const {
    const uint32_t across = opposite(core::previous(corner));
    return across == no_corner() ? across : core::previous(across);
  }

 private:
  bool link_neighbours(std::span<const std::array<uint32_t, 3>> neighbours);
  std::vector<bool> link_faces(uint32_t vertex_limit);
  void break_folds(const std::vector<bool>& may_fold, uint32_t vertex_limit);
  std::vector<uint32_t> see_fans(uint32_t vertex_limit);
  void separate_fans(uint32_t vertex_limit);
  void unlink(uint32_t corner);

  uint32_t face_count_ = 0, flat_count_ = 0, vertex_count_ = 0;
  std::unique_ptr<Face[]> faces_;  // and the one of no_corner()
  std::unique_ptr<VertexState[]> states_;
};

}  // namespace psplit
