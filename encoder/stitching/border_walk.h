// The border of a patch as points in walking order.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

using Face = std::array<uint32_t, 3>;

// A directed edge a -> b of a face is a border edge if no face of the patch has b -> a. Walks start at the
// lowest-numbered border point that is not walked yet, and follow border edges until they close. The loops
// follow each other in the result. A patch has no walk (empty) if two border edges leave one of its points, or
// if a walk does not close. Its references, and those to it, are then stored as pairs.
std::vector<uint32_t> border_walk(std::span<const Face> faces, uint32_t point_count);

}  // namespace psplit
