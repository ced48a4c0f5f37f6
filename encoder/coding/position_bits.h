// The bits of positions on their grid: the fewest that the edges of the mesh, or a bound on the error, allow.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// Draco's own default, which meshes of few, long edges get.
inline constexpr int kLeastBitsForEdges = 11;

// The lengths of some edges of a mesh, evenly spread over its faces. The sample depends only on the faces and
// their numbers, not on the order in which they come. So a mesh in memory and the same mesh read as a stream
// have the same sample. Not thread-safe.
class EdgeSample {
 public:
  // Keeps at most `most_faces` faces, and a quarter of that at least if the mesh has as many.
  explicit EdgeSample(size_t most_faces = size_t{1} << 15) : most_faces_(most_faces) {}

  // Whether the sample wants the face with this number. A caller that finds the face's points only then saves
  // time.
  bool wants(uint64_t face) const { return (hash_of(face) & mask_) == 0; }
  // Ignored unless wants(face).
  void add(uint64_t face, const std::array<std::array<float, 3>, 3>& corners);
  // All faces of a mesh whose POSITION has three floats.
  void add(const Mesh& mesh);

  // The edges' lengths in any order. An edge of two faces may be there twice. Edges of no length are left out.
  std::vector<float> lengths() const;

 private:
  struct Face {
    uint64_t hash;
    std::array<float, 3> lengths;
  };
  static uint64_t hash_of(uint64_t face);

  size_t most_faces_;
  uint64_t mask_ = 0;  // faces whose hash has one of these bits are left out
  std::vector<Face> faces_;
};

// The grid step that the edges allow: a twentieth of the length that 95 % of them exceed. On 23 scans and
// similar surfaces, 95 % of the faces then turn by less than 2.4 degrees (docs/precision.md). 0 if there are no
// lengths.
double step_for_edges(std::vector<float> lengths);

// The fewest bits, from kLeastBitsForEdges to kMostGridBits, for which the step of the grid is at most
// `step`. But the step is never finer than the floats: half the distance of two floats near the grid's largest
// coordinate. `grid` is fit_grid's, with any bits.
int position_bits_for_step(const AttributeCoding& grid, double step);

// The fewest bits for which no decoded position is farther than `max_error` from its input, in a straight line
// (distance_bound). Errors: kUsage if 30 bits do not suffice, because floats are too coarse for these
// coordinates.
Expected<int> position_bits_for_error(const AttributeCoding& grid, double max_error);

// The value as text with three digits.
std::string rounded_text(double value);

// How far a decoded position may be from its input: the length of grid_bound over all components.
double distance_bound(const AttributeCoding& grid);

}  // namespace psplit
