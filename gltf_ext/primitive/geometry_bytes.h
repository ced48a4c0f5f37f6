// The bytes that a document stores for the geometry of its primitives.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// For each primitive, the bytes that the document stores for its attributes and indices: the stream or
// container of a compressed primitive, and the elements of accessors, without gaps between them. Of a view that
// meshoptimizer compressed it is their share of its compressed bytes. Morph targets
// do not count, because they are never compressed. Accessors that only describe the data of a stream do not
// count either. Data that several primitives share count for the first of them.
std::map<PrimitiveId, uint64_t> geometry_bytes(const Document& document);

// The sum for these primitives. Data that several of them share count once.
uint64_t geometry_bytes(const Document& document, std::span<const PrimitiveId> primitives);

// Which data of a document belong to geometries alone.
class GeometryOwners {
 public:
  // Counts the users of each accessor and buffer view. The document must outlive the object.
  explicit GeometryOwners(const Document& document) : document_(document), users_(document.json()) {}

  using Groups = std::vector<const PrimitiveGroup*>;
  // Divides the groups into sets that share no accessor and no buffer view with data: indices into `groups`.
  std::vector<std::vector<size_t>> sharing_sets(const Groups& groups) const;

  // The bytes that the document would lose with these geometries and their morph targets. Accessors and buffer
  // views that other objects use stay, whole.
  uint64_t bytes_of(const Groups& groups) const { return freed_by(groups).bytes; }

  // What these are, too. An accessor that data of other objects share a view with goes, and its view stays.
  struct Freed {
    std::set<int64_t> accessors, views;
    uint64_t bytes = 0;
  };
  Freed freed_by(const Groups& groups) const;

 private:
  const Document& document_;
  const DataUsers users_;
};

}  // namespace psplit
