// GPUs by name, as far as patches are cut for them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace psplit {

// How many multiprocessors a GPU has, by a name like "H100" or "rtx 4090", or the number itself.
std::optional<uint32_t> multiprocessors(const std::string& gpu);
// The names that multiprocessors knows, with commas between them.
std::string known_gpus();

// How many patches occupy so many multiprocessors: a warp of patches for each of their four schedulers, rounded
// to a multiple of 512 (the paper's section 4.3).
uint32_t patches_in_flight(uint32_t multiprocessors);

}  // namespace psplit
