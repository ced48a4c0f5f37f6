// Chooses how each attribute of a mesh is stored.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "src/export.h"
#include "src/mesh/mesh.h"

namespace psplit {

// Bits of a component on its quantization grid; 0 keeps the values exactly as they are.
struct CodingOptions {
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  bool lossless = false;  // every attribute exactly as it is
};

// One coding per attribute of the mesh. Values that no grid can hold are kept exactly: integers, values that
// are not finite, and normals that are not unit vectors. So are attributes that name things: feature ids
// (_FEATURE_ID_n of EXT_mesh_features, _BATCHID of 3D Tiles) and the semantics in `exact`.
//
// Values of quantized attributes that exceed glTF's limits by rounding noise are set to the limits first
// (trim_noise). Call round_weights when all grids are final: meshes that share a grid merge theirs before that
// (merge_grids).
PSPLIT_EXPORT std::vector<AttributeCoding> choose_codings(Mesh& mesh, const CodingOptions& options,
                                                          const std::set<std::string>& exact = {});

}  // namespace psplit
