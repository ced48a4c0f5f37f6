// A material of glTF as MTL, as far as MTL can express it.
#pragma once

#include <functional>
#include <set>
#include <string>

#include "gltf_ext/json/json.h"

namespace psplit {

// The path of an image of the document as the MTL file names it; empty if it has no file.
using PathOfImage = std::function<std::string(size_t image)>;

// The lines of one material: base colour, alpha, emission, roughness, metalness, and textures of these and of
// normals, with offset and scale. What MTL cannot hold is added to `left_out`, by its name in glTF.
std::string mtl_text(const Json& json, int64_t material, const std::string& name,
                     const PathOfImage& path_of_image, std::set<std::string>& left_out);

}  // namespace psplit
