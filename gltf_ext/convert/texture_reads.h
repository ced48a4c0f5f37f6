// Which texture coordinates the textures of a primitive read, and how they enlarge them.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>

#include "gltf_ext/document/document.h"

namespace psplit {

// The sets of texture coordinates that textures read, and the largest factor of KHR_texture_transform for each.
using TextureReads = std::map<int64_t, double>;

// Adds the sets that textures in a tree of JSON read. Any object with an index may be a texture.
void collect_texture_reads(const Json& tree, TextureReads& reads);

// The materials of the primitive and of its variants.
std::set<int64_t> materials_of(const Json& primitive);

// For each TEXCOORD_n, the largest factor, 1 or more, by which a material of one of the primitives enlarges it.
std::map<std::string, double> texture_scales(const Document& document, std::span<const PrimitiveId> ids);

}  // namespace psplit
