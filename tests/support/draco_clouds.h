// Draco point clouds of every kind that libdraco's encoder writes, and some of bitstream 2.2, which it only
// reads.
#pragma once

#include <functional>
#include <vector>

#include "tests/support/draco_streams.h"

namespace psplit {

// Makes clouds with every coding, level, type of values and count of bits, always in the same order and with
// the same bytes. libdraco can decode all of them. Most have at most some thousand points.
void for_each_draco_cloud(const std::function<void(const DracoStream&)>& visit);

// The clouds of at most 4,000 bytes. A process makes them once.
const std::vector<DracoStream>& small_draco_clouds();

}  // namespace psplit
