// Tables of frequencies: how many of core::kSlots slots each symbol of a table has.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

// The frequencies that code these counts in the fewest bits. Each symbol that occurs has at least 1, and the
// sum is 4096. All are 0 if no symbol occurs. `counts` has at most 4096 symbols.
std::vector<uint16_t> fitting_frequencies(std::span<const uint64_t> counts);

// The bits that symbols with these counts take.
double coded_bits(std::span<const uint64_t> counts, std::span<const uint16_t> frequencies);

// The probability of a 1, in 1 / 4096, that codes `zeros` zeros and `ones` ones in the fewest bits: 1 to 4095.
uint32_t fitting_probability(uint64_t zeros, uint64_t ones);

}  // namespace psplit
