// gltf-psplit compare A B for assets that are larger than memory: meshes are compared by sums of hashes of
// their triangles (gltf_ext/compare/triangle_sums.h).
//
// Primitives are paired as compare_assets pairs them, and must have the same attributes and materials. If one
// side declares a grid for an attribute, and the other stores the values exactly, the exact values are rounded
// to the grid as an encoder rounds them (gltf_ext/compare/rounded_mesh.h). Equal sums then mean that every
// value is what quantization makes of the other. The comparison proves less than compare_assets: which
// triangles differ is known only to a cell of the meshes' box, and values within a tolerance are not paired. So
// attributes whose types or grids differ are undecided, unless they are equal bit for bit.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/compare/triangle_sums.h"
#include "tools/gltf_psplit/sameness/large_asset.h"

namespace psplit {

// A worse verdict has a larger number.
enum class LargeVerdict { kSame, kUndecided, kDiffers };

struct LargeComparison {
  struct Mesh {
    LargeVerdict verdict = LargeVerdict::kSame;
    uint64_t triangles[2] = {}, degenerate[2] = {};  // of both assets
    std::vector<std::string> rounded;                // attributes that were rounded to the other asset's grid
    std::vector<std::string> undecided;              // attributes that sums cannot compare
    std::vector<std::string> differing;              // attributes whose values differ
    std::string what;                                // a difference of primitives as wholes, or empty
    uint64_t differing_cells = 0;
    PositionBox difference{};  // around those cells
  };
  std::vector<Mesh> meshes;
  size_t mesh_counts[2] = {};
  LargeVerdict verdict() const;
  // Of all meshes, with each attribute once.
  Mesh sum() const;
};

// `only`: if it is not empty, only these attributes and POSITION are compared. `folder` is that of temporary
// files, which take the size of the rounded attributes. Errors: kInvalidInput, those of the files.
Expected<LargeComparison> compare_large(const LargeAsset& a, const LargeAsset& b,
                                        const std::vector<std::string>& only,
                                        const std::filesystem::path& folder, const ThreadPool& pool);

}  // namespace psplit
