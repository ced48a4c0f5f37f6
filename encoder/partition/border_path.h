// The border between two patches as a path of mesh edges, and the shortest one beside it.
//
//        third patch
//   ---S---v0---S---      Faces of a lie left of the border on its way from v0 to vn, those of b right. A least
//     a     |     b       cut of faces in a plane is a shortest path of edges in it, which a breadth-first
//     search
//           |             finds at once: from sources S, the vertices around v0 on the rim of both patches, to
//   ---T---vn---T---      targets T around vn, over vertices inside.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/partition/cell_graph.h"

namespace psplit {

// Made for reuse: memory is kept. Faces of patches a and b are the caller's alone while it works; others may
// change what other faces are in.
class BorderPath {
 public:
  // Of equally short paths, the one furthest into a patch, or nearest to the border of now.
  enum class Preference { kIntoA, kIntoB, kNearest };
  // A stretch of border from v0 to vn.
  struct Chain {
    uint32_t first = 0, end = 0;
    uint32_t length() const { return end - first; }
  };

  BorderPath(const FaceGraph& graph, std::vector<uint32_t>& patch_of)
      : graph_(graph), patch_of_(patch_of), place_(graph.vertex_count, 0), marks_(graph.faces.size(), 0) {}

  // Follows the border through the faces on it. False where a part of it has no two ends, as around a tube, or
  // where faces do not agree on what is left and right.
  bool trace(uint32_t a, uint32_t b, std::span<const uint32_t> border_faces);
  std::span<const Chain> chains() const { return chains_; }

  // Collects the vertices up to so many edges beside a chain.
  void look_around(const Chain& chain, int into_a, int into_b);
  // The number of edges of a shortest path, all of whose vertices are at least and at most so many edges inside
  // of a (below 0: of b); 0 where there is none.
  uint32_t find(int least, int most, Preference preference);
  // Which faces change sides with the path found. False where that is not clear.
  bool divide();
  std::span<const uint32_t> to_a() const { return to_a_; }
  std::span<const uint32_t> to_b() const { return to_b_; }
  // Moves them. False, and nothing is moved, where a patch might come apart.
  bool apply();

 private:
  static constexpr uint32_t kNone = 0xffffffffu;
  enum class Kind : uint8_t { kInside, kSource, kTarget, kBarred };
  struct Side {
    uint32_t face = kNone, side = 0;
    bool operator==(const Side&) const = default;
  };
  struct Vertex {
    uint32_t vertex = 0, face = 0;  // of the mesh; one that has it
    int depth = 0;                  // edges from the chain, into a; below 0 into b
    Kind kind = Kind::kInside;
    bool is_on_chain = false;
    uint32_t first_arc = 0, end_arc = 0;
    uint32_t distance = 0;  // from the sources
  };
  struct Arc {
    uint32_t to = 0;  // of vertices_
    Side side;        // the edge there
  };

  uint32_t patch_of(uint32_t face) const { return load_shared(patch_of_[face]); }
  bool is_in(uint32_t face, uint32_t patch) const { return face != kNoCell && patch_of(face) == patch; }
  uint32_t neighbour(Side side) const { return graph_.faces[side.face].neighbours[side.side]; }
  uint32_t from(Side side) const { return graph_.faces[side.face].vertices[side.side]; }
  uint32_t to(Side side) const;
  uint32_t other_end(Side side, uint32_t vertex) const;
  uint32_t corner_of(uint32_t face, uint32_t vertex) const;
  Side across(Side side, uint32_t vertex) const;
  bool is_plain(Side side) const;
  template <typename Visit>
  Side turn(Side side, uint32_t vertex, Visit visit) const;
  Side turn_within(Side side, uint32_t vertex, uint32_t patch) const;

  bool trace_from(Side start);
  bool step(Side& side, bool is_forward) const;
  void walk_rim(Side side, uint32_t vertex, int most, int step, Kind kind);
  uint32_t* find_place(uint32_t vertex);
  uint32_t add(uint32_t vertex, uint32_t face, int depth, Kind kind);
  void expand(uint32_t index, int into_a, int into_b);
  bool mark(uint32_t face, uint32_t bit);
  bool is_marked(uint32_t face, uint32_t bit) const {
    return marks_[face] >> kMarkBits == mark_stamp_ && (marks_[face] & bit) != 0;
  }
  bool flood(std::vector<uint32_t>& moved, uint32_t from);
  bool is_divided() const;

  const FaceGraph& graph_;
  std::vector<uint32_t>& patch_of_;
  uint32_t a_ = 0, b_ = 0;
  std::vector<Side> sides_;  // of the chains, of faces of a
  std::vector<Chain> chains_;
  std::vector<Vertex> vertices_;
  std::vector<uint32_t> place_;  // of vertices of the mesh in vertices_, if they are there
  std::vector<Arc> arcs_;
  std::vector<uint32_t> queue_;
  std::vector<Side> path_;  // from source to target, of faces on the left once it is divided
  std::vector<uint32_t> to_a_, to_b_;
  // Of each face: bit k for side k of a border or path, kMoved, above them the stamp that makes them count.
  static constexpr uint32_t kMoved = 8, kMarkBits = 4;
  std::vector<uint32_t> marks_;
  uint32_t mark_stamp_ = 0;
};

}  // namespace psplit
