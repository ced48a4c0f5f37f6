// Whether two assets hold the same meshes up to order and quantization, and where they first differ.
//
// Two meshes are the same if each triangle of one has a partner in the other with the same values at its
// corners and the same orientation. Points may be split or merged as long as their values stay. Elements may
// come in any order and begin at any corner. Two values may differ by as much as the files' own quantization
// grids allow: the grids of Draco streams, and of integers if the other file stores another type. Otherwise
// values must be equal to the bit, except for the sign of zero. Lines and points are compared in the same way.
// Morph targets are compared as attributes of the points that they move.
//
// Positions may be relative to an origin (AssetPrimitive::origin), which is added in double precision.
//
// Not compared: nodes and their transforms; materials, except for their number, if both assets have equally
// many; names; points that no element uses; and degenerate triangles, which encoders drop. The last two are
// counted.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "psplit/parallel.h"
#include "tools/gltf_psplit/diff/read_asset_meshes.h"

namespace psplit {

struct CompareRules {
  // Tolerances that replace the declared grids, by attribute. Each is a share of the attribute's extent in the
  // first asset (of 1 for normals, tangents, colours and weights). "" applies to all other attributes. Joints
  // and ids stay exact.
  std::map<std::string, double> tolerances;
  std::vector<std::string> attributes;  // if not empty, only these attributes and POSITION are compared
};

// The first difference. Numbers that do not apply are -1.
struct AssetDifference {
  bool in_b = false;  // mesh, primitive and element count in the second asset
  int64_t mesh = -1, primitive = -1, element = -1, corner = -1;
  int corner_count = 3;              // of the element: 3 for a triangle, 2 for a line, 1 for a point
  int64_t partner = -1;              // the nearest element without a partner in the other asset
  std::string attribute;             // or empty
  std::vector<double> value, other;  // of the attribute, in the asset of the element and in the other
  std::string what;                  // a sentence without its subject: "has no counterpart"
};

struct AssetComparison {
  struct Counts {
    uint64_t triangles = 0, lines = 0, points = 0;  // elements
    uint64_t primitives = 0;
    uint64_t alone = 0;             // elements that should have a partner but have none
    uint64_t degenerate_alone = 0;  // triangles without area (is_degenerate) that have no partner
    uint64_t unused_points = 0;
    uint64_t without_data = 0;  // primitives that are not compared, because no buffer has their values
  };
  struct Values {
    std::string attribute;
    double largest = 0;    // difference of a component, or chord between unit vectors, over all pairs
    double tolerance = 0;  // the largest that was allowed
  };
  Counts a, b;
  std::vector<Values> values;  // by attribute, in order of names
  uint64_t recut_meshes = 0;   // meshes whose elements are in other primitives
  std::optional<AssetDifference> first;
  bool same() const { return !first; }
};

// What a comparison may use.
struct CompareMeans {
  const ThreadPool& pool;
  uint64_t memory = 0;  // for pairing, besides a few bits for each element; 0: no limit
};

// Errors: kRuntimeFailure and kUnsupported (match_elements.h), kUnsupported (2^32 elements and more in one
// mesh).
Expected<AssetComparison> compare_assets(const AssetMeshes& a, const AssetMeshes& b, const CompareRules& rules,
                                         const CompareMeans& means);

}  // namespace psplit
