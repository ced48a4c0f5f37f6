// Sums of hashes of elements: a quick proof that two bags have the same elements, for bags of any size.
//
// The hash of an element (128 bits) covers the values at its corners, beginning at its smallest corner, so that
// order, numbering and the first corner do not count, but the orientation does. Sums are modulo 2^128. Equal
// sums and counts show that the elements are the same, each as often: for two different bags that were
// not constructed to have them, the chance of equal sums is about 2^-128.
//
// If one side is on a declared grid, the values of the other are first rounded to it, as an encoder does. Then
// equal sums pair the elements of both sides one to one, and the values of partners differ by what was rounded
// off. So they are partners for match_elements as well, if that is within the limits. No crack can be between
// them: rounding makes one position of one. Triangles with two equal positions are left out, because encoders
// drop them. Sums that differ show nothing.
#pragma once

#include <optional>
#include <vector>

#include "psplit/encode.h"
#include "psplit/parallel.h"
#include "tools/gltf_psplit/diff/elements.h"

namespace psplit {

// For each column of one side, the grid to which it is rounded, or null.
using RoundingGrids = std::vector<const AttributeCoding*>;

struct EqualSums {
  std::vector<double> rounded_off;  // in each column, the most, as ElementPair::difference measures it
  std::vector<uint32_t> left_out[2];
};
// Nothing if the sums of both bags differ.
std::optional<EqualSums> equal_sums(const ElementPair& pair, const RoundingGrids& grids_of_a,
                                    const RoundingGrids& grids_of_b, const ThreadPool& pool);

}  // namespace psplit
