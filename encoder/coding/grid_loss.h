// Counts what a mesh tells apart and a grid makes equal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

struct LostShare {
  uint64_t lost = 0, all = 0;

  LostShare& operator+=(const LostShare& other) {
    lost += other.lost;
    all += other.all;
    return *this;
  }
};

// The distribution of each component's values. Limits come from all values, quantiles from a sample.
class ValueSpread {
 public:
  // Ignores points whose flag in `stored` is 0, if there are flags.
  void add(const Attribute& attribute, Span<const uint8_t> stored);

  size_t component_count() const { return components_.size(); }
  // The difference of the largest and the smallest value; 0 if it is not more than the noise of floats.
  double extent(size_t component) const;
  // The extent of the values without the smallest 2 % and the largest 2 %.
  double inner_extent(size_t component) const;

 private:
  struct Component {
    float low = 0, high = 0;
    std::vector<float> sample;
  };
  double above_noise(size_t component, double extent) const;
  std::vector<Component> components_;
};

// What a grid that is not octahedral loses of positions or texture coordinates. Meshes in parts add up; a point
// that several parts have counts for each.
struct GridLoss {
  LostShare faces;      // that have an area, and none on the grid
  LostShare points;     // positions that differ, and coincide with another on the grid
  LostShare edges;      // whose ends have different texture coordinates, and equal ones on the grid
  LostShare moved;      // texture coordinates that move by more than kTextureError of a texture
  double farthest = 0;  // that one of them moves, in textures

  void add_positions(const Mesh& mesh, const Attribute& attribute, const AttributeCoding& grid,
                     Span<const uint8_t> stored, const ThreadPool& pool);
  // `scale` enlarges the coordinates.
  void add_texture_coordinates(const Mesh& mesh, const Attribute& attribute, const AttributeCoding& grid,
                               Span<const uint8_t> stored, double scale, const ThreadPool& pool);
};

}  // namespace psplit
