// Chooses how each attribute of a mesh is stored.
#pragma once

#include <string>
#include <vector>

#include "encoder/coding/quantization.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// Whether the bits of the attribute are given.
bool are_given(const Attribute& attribute, const CodingOptions& options);

// The bits that the options request for the attribute. 0 for attributes that are kept exactly: integers,
// feature ids (_FEATURE_ID_n of EXT_mesh_features, _BATCHID of 3D Tiles) and the attributes in `exact`. Also 0
// for morph targets, whose grids follow from other attributes' (target_codings.h).
int wanted_bits(const Attribute& attribute, const CodingOptions& options);

// The bounds by which the attribute's coding is chosen (bounds_of); empty if the coding does not depend on
// them.
CodingBounds wanted_bounds(const Attribute& attribute, const CodingOptions& options,
                           Span<const uint8_t> stored = {});

// The coding of an attribute by the bounds of the values that are stored. Values that no grid can hold are kept
// exactly: values that are not finite, and normals that are not unit vectors. Attributes without a meaning that
// glTF defines are data: if all their values are whole numbers, these are kept, too, on a grid of the bits that
// this takes (fit_whole_numbers), or exactly.
AttributeCoding choose_coding(const Attribute& attribute, const CodingBounds& bounds,
                              const CodingOptions& options);

// What the coding loses against the wish to keep whole numbers, because the options have fewer bits: a
// sentence, or nothing.
std::string loss_of_whole_numbers(const Attribute& attribute, const CodingBounds& bounds,
                                  const AttributeCoding& coding);

// The coding of an attribute with a grid of its own, fitted to all of its values. Values that exceed glTF's
// limits by rounding noise are set to the limits first (trim_noise).
AttributeCoding choose_coding(Attribute& attribute, const CodingOptions& options);

}  // namespace psplit
