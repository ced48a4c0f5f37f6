// Scalar fields whose zero sets are the sample surfaces: negative inside, positive outside.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tools/gltf_psplit/shapes/noise.h"

namespace psplit {

enum class FieldKind { kTerrain, kBlob, kGyroid, kRing, kPebbles };

class Field {
 public:
  virtual ~Field() = default;

  // The field at p, exact wherever it is within `band` of zero. Elsewhere any value of the same sign that is
  // beyond `band` and not farther from zero than the field: what lets a caller skip empty space cheaply.
  virtual double at(Vec3 p, double band) const = 0;

  // How fast values change over a unit of length, at most. Where one did change faster, a feature smaller than
  // a cell may be lost; the surface stays whole.
  virtual double slope() const = 0;

  // The box that holds the surface; an open surface ends at its sides in x and z.
  Vec3 low{-1, -1, -1}, high{1, 1, 1};
  bool closed = true;
};

std::unique_ptr<Field> make_field(FieldKind kind, uint64_t seed);

}  // namespace psplit
