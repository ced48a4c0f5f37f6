// Whether two assets hold the same meshes up to order and quantization, and where they first differ.
//
// The same are they where each triangle of one has a partner in the other, with the same values at its corners
// and the same orientation. Points may be split or merged as long as their values stay, and elements may come
// in any order and begin at any corner. Values may be as far apart as the grids allow that the files themselves
// declare: those of Draco streams, and of integers where the other file has another type. Otherwise they are
// equal to the bit, but for the sign of zero. Lines and points are compared in the same way, and so are morph
// targets, as attributes of the points that they move.
//
// Not compared: nodes and what they do to meshes, materials (but for their number, where both assets have as
// many), names, points that nothing uses, and degenerate triangles, which encoders drop: both are counted.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gltf_ext/compare/declared_grids.h"

namespace psplit {

struct AssetPrimitive {
  PrimitiveId id;
  size_t whole = 0;  // what it is part of: its mesh, or a scene
  int64_t material = -1;
  int corner_count = 3;  // of its elements: 3 of triangles, 2 of lines, 1 of points
  Mesh mesh;             // `faces` are the elements; morph targets are attributes: "target 0 POSITION"
  std::map<std::string, DeclaredGrid> grids;
};

struct AssetMeshes {
  std::vector<AssetPrimitive> primitives;  // in the order of meshes
  size_t whole_count = 0;                  // `whole` is below
  size_t material_count = 0;
};

// Errors: what a primitive does not read for, with its place.
Expected<AssetMeshes> read_asset_meshes(const Document& document, const DecodeBackend& backend,
                                        const DescribeStream& describe, const ThreadPool& pool,
                                        const Progress& progress = {});

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

// Errors: kRuntimeFailure (match_elements.h), kUnsupported (2^32 elements and more in one mesh).
Expected<AssetComparison> compare_assets(const AssetMeshes& a, const AssetMeshes& b, const CompareRules& rules);

}  // namespace psplit
