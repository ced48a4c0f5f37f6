// Which primitives of a document are encoded, in memory or in parts, and which stay as they are.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/out_of_core/temporary_space.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/gltf.h"

namespace psplit {

// Why primitives are left as they are.
using SkippedPrimitives = std::map<PrimitiveId, std::string>;

// The name of an extension of the primitive whose data follow the order of points or faces; null if it has
// none.
const char* order_dependent_extension(const Json& primitive);

inline constexpr const char* kOnlyDegenerate = "no triangles but degenerate ones";

// Equal primitives are one group.
struct SelectedPrimitives {
  std::vector<PrimitiveGroup> in_memory;
  std::vector<PrimitiveGroup> large;  // primitives that do not fit into memory together with the others
  SkippedPrimitives skipped;
  uint64_t face_count = 0;  // of all groups

  void skip(const PrimitiveGroup& group, const std::string& reason) {
    for (const PrimitiveId id : group.ids) skipped[id] = reason;
  }
};

// Errors: kUnsupported if a primitive in patches cannot follow the options (options_of_patches), or if a large
// one shares its grid, or with keep_unused its points, with others: parts are encoded before the others are
// read.
Expected<SelectedPrimitives> select_primitives(const Document& document, const EncodeDocumentOptions& options,
                                               const OutOfCoreOptions& limits = {});

// What the accessors state.
ExpectedSizes stated_size(const Document& document, PrimitiveId id);

}  // namespace psplit
