// Grids whose step is a power of two. Libdraco's float arithmetic has no rounding on them, so that chosen
// values come back exactly.
#pragma once

#include <array>
#include <optional>

#include "encoder/coding/quantization.h"
#include "psplit/base.h"
#include "psplit/encode.h"

namespace psplit {

// The grid that keeps all values exactly, if these are whole numbers: its step is the largest power of two of
// which every value is a multiple, mostly 1. Nothing if a value is not a whole number, or if the extent takes
// more than 24 bits.
std::optional<AttributeCoding> fit_whole_numbers(const CodingBounds& bounds);

// A grid with a step of at most `step` that has the extremes of the last component exactly, which are 1 or -1
// each: TANGENT.w. `bounds` must be finite. Nothing if there is no such grid of 30 bits.
std::optional<AttributeCoding> fit_with_units(const CodingBounds& bounds, double step);

// Meshes on one grid touch where nodes of a scene move them by multiples of its step. Replaces this grid, in
// all meshes, by one with a power of two as its step, which is no larger, and with places at its multiples.
// False, without a change, if the meshes have several grids, if that takes more than 23 bits, or if an offset
// is not a multiple of the step.
bool fit_to_offsets(Span<AttributeCoding* const> grids, Span<const std::array<double, 3>> offsets);

}  // namespace psplit
