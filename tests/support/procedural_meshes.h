// The meshes that every stage is tested on: the built-in shapes, and small meshes that each break some
// assumption.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "psplit/mesh.h"

namespace psplit {

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

// A process makes each of these once.

// Meshes that are valid glTF but unusual in as many ways as possible.
const std::vector<NamedMesh>& nasty_meshes();

// Grids at the limit of 16-bit indices, which take as long as all other meshes together.
const std::vector<NamedMesh>& large_grids();

// Every built-in shape with some thousand faces, with and without normals and texture coordinates.
const std::vector<NamedMesh>& procedural_meshes();

// procedural_meshes, then nasty_meshes.
const std::vector<NamedMesh>& all_meshes();

// A sheet whose points are all at different places, with floats of every kind: zeros of both signs, subnormals,
// the largest and the smallest, and arbitrary bits. All attributes except POSITION also have infinities and
// NaNs. Only lossless coding supports it.
Mesh floats_of_every_kind();

// A sheet with normals, texture coordinates and other floats. Most edges are about as long as the box of the
// values: on a grid of many bits, what an encoder predicts from neighbours is outside the grid, or overflows.
Mesh long_edges();

// A surface with seams in normals and texture coordinates, and morph targets: of positions, everywhere and in
// one place; of normals, where these have seams; and one with seams of its own.
Mesh with_targets();
// A bent grid of `size` squares a side, with targets that move parts of it, and of which some resemble others.
Mesh with_alike_targets(uint32_t size, uint32_t targets);

// Functions from which tests build meshes.

using Faces = Array<std::array<uint32_t, 3>>;

template <typename T>
Attribute make_attribute(std::string semantic, ComponentType type, uint8_t component_count, bool normalized,
                         const std::vector<T>& values) {
  Attribute attribute{std::move(semantic), type, component_count, normalized, {}};
  attribute.values.resize(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  return attribute;
}

// As above, for floats.
inline Attribute float_attribute(std::string semantic, uint8_t component_count,
                                 const std::vector<float>& values) {
  return make_attribute(std::move(semantic), ComponentType::kFloat32, component_count, false, values);
}

// The values of an attribute whose components are of the type T.
template <typename T>
std::vector<T> values_of(const Attribute& attribute) {
  std::vector<T> values(attribute.values.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), attribute.values.data(), attribute.values.size());
  return values;
}

// The points `points` of a mesh, in this order, without faces.
Mesh take_points(const Mesh& mesh, const std::vector<uint32_t>& points);

// Appends copies of the points [first, end).
void append_points(Mesh& mesh, uint32_t first, uint32_t end);

// Appends another mesh with the same attributes, or the first one.
void append_mesh(Mesh& to, const Mesh& mesh);

// A mesh whose POSITION has three floats for each point.
Mesh make_mesh(const std::vector<float>& positions, Faces faces);

// columns x rows quads of two triangles each in the plane z = 0, with (columns + 1) * (rows + 1) points.
Mesh make_grid(uint32_t columns, uint32_t rows);

}  // namespace psplit
