// GPUs by name: how many patches each decodes at once.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace psplit {

// The number of multiprocessors of a GPU, from a name like "H100" or "rtx 4090", or from the number itself (1
// to 4096). Nothing if the name is unknown.
std::optional<uint32_t> multiprocessors(const std::string& gpu);
// The names that `multiprocessors` knows, separated by commas.
std::string known_gpus();

// The number of patches that keep `multiprocessors` multiprocessors busy: a warp of patches for each of the
// four schedulers of each, rounded to a multiple of 512 (the paper's section 4.3).
uint32_t patches_in_flight(uint32_t multiprocessors);

}  // namespace psplit
