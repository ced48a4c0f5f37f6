// Finds equal points and equal values, which make vertices, seams and duplicates.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

// Points with the same entry in value_of_point share that attribute's value. Points that share a position make
// a vertex; different values at a vertex make a seam.
struct WeldedMesh {
  const Mesh* mesh = nullptr;
  // For each attribute of the mesh and each point, the lowest point that has the same value.
  std::vector<std::vector<uint32_t>> value_of_point;
  // For each attribute the attribute whose seams it has: itself, unless it is a morph target that changes only
  // where another attribute does. Streams store the seams of the other one. Empty: each has its own.
  std::vector<size_t> seams_of{};

  bool has_own_seams(size_t attribute) const { return seams_of.empty() || seams_of[attribute] == attribute; }
};

// For each row of `bytes`, the lowest row with the same `stride` bytes and, if `group` is not empty, the same
// group. Values are compared as bits: -0 and 0 differ, and a NaN equals itself.
std::vector<uint32_t> lowest_equal_rows(uint32_t row_count, std::span<const std::byte> bytes, size_t stride,
                                        std::span<const uint32_t> group, const ThreadPool& pool);

// Whether no row equals a lower one.
bool are_all_lowest(std::span<const uint32_t> lowest);

// Returns the bytes by which the values of an attribute, given by its index, are compared, with the attribute's
// stride. None: the values themselves.
using ComparedBytes = std::function<Array<std::byte>(size_t)>;

// For each point the lowest point that equals it in every attribute and in the extra bytes.
std::vector<uint32_t> find_duplicates(const Mesh& mesh, std::span<const std::byte> extra, size_t extra_stride,
                                      const ThreadPool& pool, const ComparedBytes& compared = {});

// Points of equal position share a vertex, and points of one vertex share equal values. If points are equal in
// every attribute, each gets a value of its own in the last attribute, so that they stay apart. With
// `differ_in_positions`, all positions are known to differ.
WeldedMesh weld(const Mesh& mesh, const ThreadPool& pool, bool differ_in_positions = false);

// Gives different vertices to the different points of each face: morph targets and skins may move points apart
// that have one position. Then Edgebreaker can encode every face that repeats no index.
void separate_flat_faces(WeldedMesh& welded);

}  // namespace psplit
