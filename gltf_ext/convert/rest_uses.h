// What the accessors are for whose values stay in buffer views, and how exact these have to stay.
#pragma once

#include <cstdint>
#include <map>

#include "gltf_ext/document/document.h"
#include "psplit/gltf.h"
#include "psplit/parallel.h"

namespace psplit {

struct RestPrecision {
  enum class Kind {
    kExact,
    kBits,      // floats to that many bits, with the sign, of the largest of an accessor
    kStep,      // floats to multiples of 2^value
    kRotation,  // quaternions to numbers of that many bits
    kTurn,      // as kRotation, for a track between whose keys loaders turn the shorter way
  };
  Kind kind = Kind::kExact;
  int value = 0;
  bool keeps_apart = false;  // elements that differ must do so afterwards, or all stay exact

  friend bool operator==(const RestPrecision&, const RestPrecision&) = default;
};

// What glTF asks of the buffer view.
enum class RestView {
  kVertices,  // a stride of a multiple of 4 bytes, which the view states
  kIndices,
  kTriangles,  // indices of a list of triangles
  kPacked,     // elements without gaps, and no stride
};

struct RestUse {
  RestView view = RestView::kPacked;
  RestPrecision precision{};
  // The elements that repeat: a weight for each morph target, or a key of a spline with its two tangents.
  uint64_t period = 1;

  friend bool operator==(const RestUse&, const RestUse&) = default;
};

// The uses of accessors, by index. Accessors are left out if unknown data may name them, if only a fallback or
// coarse primitives use them, or if their uses are incompatible.
std::map<int64_t, RestUse> rest_uses(const Document& document, const EncodeDocumentOptions& options,
                                     const ThreadPool& pool);

}  // namespace psplit
