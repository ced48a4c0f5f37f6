// Morph targets as sparse accessors, which are core glTF: without loss, and read by every viewer.
#pragma once

#include "gltf_ext/primitive/accessors.h"
#include "psplit/document.h"

namespace psplit {

// Stores the morph targets of all primitives as sparse accessors where that takes fewer bytes. An accessor
// whose elements are all zero gets no data. Targets share a few buffer views, and equal targets share an
// accessor: otherwise hundreds of targets would have more JSON than data. Accessors and views that something
// else uses too, that unknown data may name, or that meshoptimizer compressed stay; and all of them if the
// asset would grow.
void make_targets_sparse(Document& document, ZeroSign sign);

// Morph targets of all primitives: of equal primitives once.
struct TargetCounts {
  size_t all = 0, in_patches = 0;  // attributes of targets
  uint64_t bytes = 0;              // of targets outside of patches, as a file stores them
};
TargetCounts count_targets(const Document& document);

}  // namespace psplit
