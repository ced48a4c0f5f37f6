// Changes the values of a mesh file to what glTF requires.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesh_files/mesh_file.h"

namespace psplit {

// Changes the values of every part, and counts the changes as losses. Normals become unit vectors. A normal of
// length 0 is replaced by one of the surrounding faces; if all have length 0, NORMAL is left out. Colours are
// clamped to [0, 1]. Numbers that are not finite become 0. Positions must be finite.
void repair_values(MeshFile& file);

// The steps, for a mesh that is never in memory as a whole.

// Everything except positions and normals, of any number of points.
void repair_floats(Attribute& attribute, Losses& losses);

// Makes the normals unit vectors, and appends `first` + i to `zeros` if normal i has no direction. Returns the
// number of changed normals.
uint64_t normalize(Attribute& normals, uint32_t first, std::vector<uint32_t>& zeros);
// Counts the changes as losses.
void say_normals(uint64_t changed, uint64_t zeros, Losses& losses);
// All normals have no direction.
void say_no_normals(Losses& losses);

// Whether a normal can become a unit vector.
bool has_direction(const std::array<float, 3>& normal);

// The normal of a triangle. Its length is twice the area.
std::array<double, 3> area_vector(const std::array<Position, 3>& corners);
// The normal that replaces one without a direction, given the sum of the area vectors of its faces.
std::array<float, 3> normal_of_faces(const std::array<double, 3>& sum);

}  // namespace psplit
