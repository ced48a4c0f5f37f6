// The rules of a comparison of two assets, and its result.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace psplit {

struct CompareRules {
  // Instead of the declared grids, as shares of an attribute's extent in the first asset (of 1 for normals,
  // tangents, colours and weights); "" is for all that have none of their own. Joints and ids stay exact.
  std::map<std::string, double> tolerances;
  std::vector<std::string> attributes;  // to compare no others than these, and POSITION
};

// Where the assets first differ. Numbers are -1 where they do not apply.
struct AssetDifference {
  bool in_b = false;  // mesh, primitive and element are those of the second asset
  int64_t mesh = -1, primitive = -1, element = -1, corner = -1;
  int corner_count = 3;              // of the element: 3 of a triangle, 2 of a line, 1 of a point
  int64_t partner = -1;              // the nearest element of the other asset without a partner
  std::string attribute;             // or empty
  std::vector<double> value, other;  // of the attribute, in the asset named first and in the other
  std::string what;                  // a sentence without subject: "has no counterpart"
};

struct AssetComparison {
  struct Counts {
    uint64_t triangles = 0, lines = 0, points = 0;  // elements
    uint64_t primitives = 0;
    uint64_t alone = 0;             // elements without a partner that should have one
    uint64_t degenerate_alone = 0;  // triangles without area that have none
    uint64_t unused_points = 0;
  };
  struct Values {
    std::string attribute;
    double largest = 0;    // difference of a component, or a chord between unit vectors, over all pairs
    double tolerance = 0;  // the largest that was allowed
  };
  Counts a, b;
  std::vector<Values> values;  // by attribute, in order of names
  uint64_t recut_meshes = 0;   // whose elements are in other primitives
  std::optional<AssetDifference> first;
  bool same() const { return !first; }
};

}  // namespace psplit
