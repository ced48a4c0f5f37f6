// The encoders of meshoptimizer's filters: rows that undo_meshopt_filter turns into values near the given ones.
// The results are the same on every processor.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace psplit {

// EXPONENTIAL: each value becomes the nearest multiple of 2^exponent, at most half of it off. Nothing if a
// value is not finite, or if a multiple does not fit the filter's 24 bits.
std::vector<uint8_t> filter_to_multiples(std::span<const float> values, int exponent);

// The exponent whose multiples have that many bits, with their sign, for the largest of the values. Nothing if
// it is near to the ends of floats, where products would overflow or lose bits.
std::optional<int> exponent_for_bits(std::span<const float> values, int bits);

// QUATERNION: unit quaternions of four floats, to numbers of 4 to 16 bits. Each becomes itself or its opposite,
// which is the same rotation.
std::vector<uint8_t> filter_rotations(std::span<const float> rotations, int bits);

}  // namespace psplit
