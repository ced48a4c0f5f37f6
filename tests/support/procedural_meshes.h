// The meshes that every stage is tested on: the built-in shapes, and small ones that each break some
// assumption.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "src/mesh/mesh.h"

namespace psplit {

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

// Valid as glTF, and as unkind as that allows. The same on every call.
std::vector<NamedMesh> nasty_meshes();

// Some thousand faces each of every built-in shape, with and without normals and texture coordinates.
std::vector<NamedMesh> procedural_meshes();

// A sheet of which no two points are one place, with floats of every kind: zeros of both signs, subnormals, the
// largest and the smallest, and arbitrary bits; in attributes but POSITION infinities and NaNs as well. Nothing
// but lossless coding takes it.
Mesh floats_of_every_kind();

// Blocks that tests build meshes of.

using Faces = Array<std::array<uint32_t, 3>>;

template <typename T>
Attribute make_attribute(std::string semantic, ComponentType type, uint8_t component_count, bool normalized,
                         const std::vector<T>& values);

// A mesh with three floats of POSITION for each point.
Mesh make_mesh(const std::vector<float>& positions, Faces faces);

// columns x rows quads of two triangles each in the plane z = 0, with (columns + 1) * (rows + 1) points.
Mesh make_grid(uint32_t columns, uint32_t rows);

}  // namespace psplit
