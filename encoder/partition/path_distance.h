// Distances between faces on the topology model (paper, sections 3.3 and 4.5): every edge has length 1, so that
// every face is an equilateral triangle, and its centre is what it is measured from.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/partition/cell_graph.h"
#include "encoder/partition/partition.h"

namespace psplit {

// Distances are whole numbers, so that every machine has the same. 97 / 56 is the square root of 3 to four
// decimals.
inline constexpr uint32_t kEdgeLength = 97;
inline constexpr uint32_t kSpokeLength = 56;  // from a centre to its vertices, and to the next centre
inline constexpr uint32_t kUnreached = 0xffffffffu;

// A face that distances are counted from, and what at.
struct Source {
  uint32_t face = 0;
  uint32_t number = 0;
  uint32_t start = 0;
};

// How far each face is from its nearest source. Faces and graph outlive it. For one thread at a time.
class DistanceMap {
 public:
  // `graph` is what face_graph makes of the faces.
  DistanceMap(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count, const FaceGraph& graph,
              PathDistance kind);

  // Adds sources, which come in the order of their starts. What lies nearer to them than to all others is
  // visited, and little else; the distances are those of a map made anew, whatever the order of calls.
  void add(std::span<const Source> sources);
  // Takes all sources away.
  void clear();

  // kUnreached where no source is connected to the face, be it by a vertex alone.
  uint32_t distance(uint32_t face) const;
  // The number of a source as near as any, or nearly so, of a face that is reached.
  uint32_t nearest(uint32_t face) const;

 private:
  struct Reach {
    uint32_t distance = kUnreached;
    uint32_t number = 0;  // of the source
  };
  // A face, seen from one of its vertices.
  struct Corner {
    uint32_t face, left, right;
  };
  // More than the longest step, so that distances in the front have buckets of their own.
  static constexpr uint32_t kBuckets = 128;

  // Nodes are vertices, then centres of faces. In fast marching only sources use their centres.
  void reach(uint32_t node, uint64_t distance, uint32_t number);
  void expand_face(uint32_t face);
  void expand_vertex(uint32_t vertex);
  void march(uint32_t vertex);

  std::span<const std::array<uint32_t, 3>> faces_;
  uint32_t vertex_count_;
  const FaceGraph& graph_;
  PathDistance kind_;
  std::vector<uint32_t> first_corner_;  // corners at vertex v are [first_corner_[v], first_corner_[v + 1])
  std::vector<Corner> corners_;
  std::vector<Reach> reaches_;                           // of nodes
  std::array<std::vector<uint32_t>, kBuckets> buckets_;  // the front: nodes by distance
  size_t front_count_ = 0;
};

}  // namespace psplit
