// The meshes of an asset, decoded, as compare_assets takes them.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/decode.h"
#include "psplit/encode.h"

namespace psplit {

// A quantization grid that a file declares: how far its values may be from the original values.
struct DeclaredGrid {
  double within = 0;  // the largest error of a component; for directions, of the chord between unit vectors
  std::string identity{};    // equal for equal grids; empty if the streams have several grids
  AttributeCoding coding{};  // the grid, or one of them; without bits if values are multiples of a power of two
};

struct AssetPrimitive {
  PrimitiveId id;
  size_t whole = 0;  // index of the mesh or the scene that has it
  int64_t material = -1;
  int corner_count = 3;  // of each element: 3 for triangles, 2 for lines, 1 for points
  // Three indices for each element, of which the first corner_count count. Morph targets are attributes
  // (name_of_target).
  MeshView view;
  std::map<std::string, DeclaredGrid> grids{};
  // What positions are relative to. Zeros unless the caller knows it; see set_origin.
  std::array<double, 3> origin{};
  // The values are in a buffer without bytes (document.h): there is nothing to compare.
  bool has_no_data = false;
  std::vector<std::shared_ptr<const void>> owned{};  // what the view points to; copies share it

  uint32_t element_count() const { return view.indices.count / 3; }
  // Makes a view of a mesh, which the primitive then owns.
  void take(Mesh mesh);
  // Equal grids of positions relative to different origins are different grids.
  void set_origin(const std::array<double, 3>& to);
};

struct AssetMeshes {
  std::vector<AssetPrimitive> primitives;  // in the order of the meshes
  size_t whole_count = 0;                  // every `whole` is below it
  size_t material_count = 0;
};

// Makes the view of a triangle primitive without reading it into memory. False if it must be read.
using ViewPrimitive = std::function<Expected<bool>(AssetPrimitive&)>;

// The document must outlive the meshes if `view` refers to it. Errors: the cause why a primitive cannot be
// read, with its place.
Expected<AssetMeshes> read_asset_meshes(const Document& document, const DecodeBackend& backend,
                                        const DescribeStream& describe, const ThreadPool& pool,
                                        const Progress& progress = {}, const ViewPrimitive& view = {});

}  // namespace psplit
