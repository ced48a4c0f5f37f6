// Distances between faces on the topology model (paper, sections 3.3 and 4.5). Every edge has length 1, so
// every face is an equilateral triangle. Distances are measured between the centres of faces.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/partition/cell_graph.h"
#include "encoder/partition/partition.h"

namespace psplit {

// Distances are integers, so that they are the same on every machine. 97 / 56 is the square root of 3 to four
// decimals.
inline constexpr uint32_t kEdgeLength = 97;
inline constexpr uint32_t kSpokeLength = 56;  // from a centre to its vertices, and to the next centre
inline constexpr uint32_t kUnreached = 0xffffffffu;

// A face from which distances are measured, and the distance at that face.
struct Source {
  uint32_t face = 0;
  uint32_t number = 0;
  uint32_t start = 0;
};

// The distance of each face to its nearest source. The faces and the graph must outlive it. Not thread-safe.
class DistanceMap {
 public:
  // `graph` must be face_graph of the faces.
  DistanceMap(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count, const FaceGraph& graph,
              PathDistance kind);

  // Adds sources, sorted by their starts. Visits little more than the faces that are nearer to them than to all
  // other sources. The distances do not depend on the order in which sources were added.
  void add(std::span<const Source> sources);
  // Removes all sources.
  void clear();

  // kUnreached if no source is connected to the face, not even by a vertex.
  uint32_t distance(uint32_t face) const;
  // The number of the nearest source, or of one nearly as near, for a face that is reached.
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
  // More than the longest step, so that each distance in the front has its own bucket.
  static constexpr uint32_t kBuckets = 128;

  // Nodes are the vertices, then the centres of faces. Fast marching uses only the centres of sources.
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
