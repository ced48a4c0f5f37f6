// The filters of meshoptimizer's extensions, and encoders of some: rows that undo_meshopt_filter turns into
// values near the given ones. The results are the same on every processor.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gltf_ext/document/asset_records.h"

namespace psplit {

// Turns the view.decoded_bytes() bytes of a legal view into the values that they stand for. Rows that no
// encoder writes become any values.
void undo_meshopt_filter(const MeshoptRecord& view, uint8_t* rows);

// EXPONENTIAL: each value becomes the nearest multiple of 2^exponent, at most half of it off. Nothing if a
// value is not finite, or if a multiple does not fit the filter's 24 bits.
std::vector<uint8_t> filter_to_multiples(std::span<const float> values, int exponent);

// Other rows of the same values: all multiples are larger by the bytes that none of them needs, and the
// exponents smaller. Small multiples then have one byte less for their signs, which the codec stores apart from
// the others.
std::vector<uint8_t> lift_multiples(std::span<const uint8_t> rows);

// The exponent of a step of which the largest value is a multiple of `bits` bits, sign included. Nothing if it
// is near the ends of the range of floats, where products would overflow or lose bits.
std::optional<int> exponent_for_bits(std::span<const float> values, int bits);

// QUATERNION: unit quaternions of four floats, to numbers of 4 to 16 bits. Each becomes itself or its opposite,
// which is the same rotation.
std::vector<uint8_t> filter_rotations(std::span<const float> rotations, int bits);

}  // namespace psplit
