// How many bytes the geometry of primitives takes in a document.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// For each mesh and primitive the bytes of its attributes and indices as the document stores them: the stream
// or container of compressed ones, and accessors without gaps between their elements. Morph targets are left
// out, because they are never compressed, and so are accessors that only describe what a stream holds. Data
// that several primitives have in common count for the first of them.
std::map<std::pair<size_t, size_t>, uint64_t> geometry_bytes(const Document& document);

// Which bytes a document would lose with a geometry.
class GeometryOwners {
 public:
  // Counts who uses each accessor and buffer view; the document outlives it.
  explicit GeometryOwners(const Document& document);

  // The geometry's bytes, or nothing where other objects use one of its accessors or buffer views: then bytes
  // remain when it goes.
  std::optional<uint64_t> bytes_of(const PrimitiveGroup& group) const;

 private:
  const Document& document_;
  std::map<int64_t, size_t> accessor_users_, view_users_;
};

}  // namespace psplit
