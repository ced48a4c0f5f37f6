// Finds equal points and equal values: what makes a vertex, a seam, a duplicate.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/welding/welded_mesh.h"
#include "src/parallel.h"

namespace psplit {

// For each row of `bytes`, the lowest row with the same `stride` bytes and, where `group` is not empty, the
// same group. Values are compared as bits: -0 and 0 differ, a NaN equals itself.
std::vector<uint32_t> lowest_equal_rows(uint32_t row_count, std::span<const std::byte> bytes, size_t stride,
                                        std::span<const uint32_t> group = {});

// For each point the lowest point that equals it in every attribute and in the extra bytes.
std::vector<uint32_t> find_duplicates(const Mesh& mesh, std::span<const std::byte> extra, size_t extra_stride);

// Vertices are points of equal position; around a vertex, points of equal value share it. Points that would be
// equal in every attribute are kept apart by a value of their own in the last attribute.
WeldedMesh weld(const Mesh& mesh, const ThreadPool& pool);

// Gives different vertices to the points of each face, where these are different points: morph targets and
// skins may move apart what one position holds together. Then Edgebreaker carries every face that repeats no
// index.
void separate_flat_faces(WeldedMesh& welded);

}  // namespace psplit
