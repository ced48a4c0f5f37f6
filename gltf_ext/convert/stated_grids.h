// The grids that the streams of compressed primitives state. Their values are on them already.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"

namespace psplit {

// The grid of each attribute of the primitive's mesh; 0 bits if its streams state none, or several. All have 0
// bits if the primitive is plain, or cannot be described.
std::vector<AttributeCoding> stated_grids(const Document& document, PrimitiveId id,
                                          const std::vector<Attribute>& attributes, const ThreadPool& pool);

// Whether both have the same places.
bool is_same_grid(const AttributeCoding& a, const AttributeCoding& b);

// For documents whose primitives are decoded before they are encoded: the grids that the streams of all
// primitives state, by attribute.
StatedGrids all_stated_grids(const Document& document, const ThreadPool& pool);

}  // namespace psplit
