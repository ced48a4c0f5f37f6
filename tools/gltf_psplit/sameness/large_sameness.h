// gltf-psplit compare A B for assets that are larger than memory: meshes are compared by sums of hashes of
// their triangles (gltf_ext/compare/triangle_sums.h).
//
// It proves less than compare_assets: which triangles differ is known only to a cell of the meshes' box, and
// values within a tolerance are not paired. Of an attribute that one asset declares a grid for, and the other
// stores exactly, the exact values are rounded to the grid as an encoder rounds them; equal sums then mean that
// every value is what quantization makes of the other. Directions and attributes whose types or grids differ
// are not compared, and named. Materials, and how a mesh is divided into primitives, do not count.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/compare/triangle_sums.h"
#include "gltf_ext/json/json.h"
#include "tools/gltf_psplit/sameness/large_asset.h"

namespace psplit {

struct LargeComparison {
  struct Mesh {
    uint64_t triangles[2] = {}, degenerate[2] = {};  // of both assets
    std::vector<std::string> rounded;                // attributes that were rounded to the other asset's grid
    std::vector<std::string> ignored;                // attributes that were not compared
    bool same = false;
    uint64_t differing_cells = 0;
    PositionBox difference;  // around those cells
  };
  std::vector<Mesh> meshes;
  size_t mesh_counts[2] = {};
  bool same() const;
};

// `only`: if it is not empty, only these attributes and POSITION are compared. Errors: kInvalidInput.
Expected<LargeComparison> compare_large(const LargeAsset& a, const LargeAsset& b,
                                        const std::vector<std::string>& only, const ThreadPool& pool);

// `first` and `second` are the names of the two assets.
std::string to_text(const LargeComparison& comparison, const std::string& first, const std::string& second);
Json to_json(const LargeComparison& comparison);

}  // namespace psplit
