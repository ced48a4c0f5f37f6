// The numbers that libdraco's encoder computes with: the values of a patch as whole steps of their grids. From
// them follows what it cannot encode, and how much memory it takes.
#pragma once

#include <cstdint>
#include <span>

#include "encoder/coding/attribute_coding.h"
#include "encoder/draco/patch_stream.h"
#include "encoder/welding/welded_mesh.h"

namespace psplit {

// Whether libdraco would predict texture coordinates from positions, and the products may exceed 64 bits at a
// corner of the patch. That needs grids of many bits, and edges about as long as the grid of positions.
// libdraco's encoder then fails, or writes a stream that newer versions of its decoder refuse. `texcoords` is
// the index of an attribute of the mesh that has two components.
bool texture_prediction_may_overflow(const WeldedMesh& welded, const PatchMesh& patch,
                                     std::span<const AttributeCoding> codings, size_t texcoords,
                                     int encode_speed);

// About the memory that libdraco's encoder takes to count the symbols of an attribute: it has an entry for
// every number up to the largest symbol. At speeds 0 and 1, which compare predictions, it takes eight times as
// much (measured: 7.5). 0 if no grid has enough bits for more than 64 MB.
uint64_t symbol_table_bytes(const WeldedMesh& welded, const PatchMesh& patch,
                            std::span<const AttributeCoding> codings, int encode_speed);

}  // namespace psplit
