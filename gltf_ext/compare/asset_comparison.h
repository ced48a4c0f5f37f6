// The rules of a comparison of two assets, and its result.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

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
  bool in_b = false;  // mesh, primitive and element are those of the second asset
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

}  // namespace psplit
