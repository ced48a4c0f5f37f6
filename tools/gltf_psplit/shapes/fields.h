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

  // The field at p. It is exact within `band` of zero. Elsewhere it may be any value of the same sign beyond
  // `band` that is not farther from zero than the field, so that a caller can skip empty space cheaply.
  virtual double at(Vec3 p, double band) const = 0;

  // The largest change of the value over a unit of length. If the field changes faster, features smaller than a
  // cell may be lost, but the surface stays closed.
  virtual double slope() const = 0;

  // The box around the surface. An open surface ends at its sides in x and z.
  Vec3 low{-1, -1, -1}, high{1, 1, 1};
  bool closed = true;
};

std::unique_ptr<Field> make_field(FieldKind kind, uint64_t seed);

}  // namespace psplit
