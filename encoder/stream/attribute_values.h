// The numbers that libdraco's encoder makes of an attribute's values.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stream/attribute_plan.h"
#include "psplit/base.h"

namespace psplit {

// `rows` are the points of the mesh whose values are stored.

// Sets the origin and the range of a plan for kQuantized as libdraco's encoder finds them in these values and
// in the extremes of the coding's grid. They equal the coding's own if fit_grid made the coding for the whole
// mesh, except that a zero has the sign of the first zero value. Rows are in any order, any number of times:
// the first value is that of the lowest row.
void set_stream_grid(const Attribute& source, const AttributeCoding& coding, std::span<const uint32_t> rows,
                     AttributePlan& plan);

// Writes the integers of each row to `out`, which has value_stride for each: places on the plan's grid, pairs
// of octahedral places, or integers as they are. Not for kRaw. Errors: kUnsupported for an integer above 2^31 -
// 1, as in libdraco.
Status write_integers(const Attribute& source, const AttributePlan& plan, std::span<const uint32_t> rows,
                      std::span<int32_t> out);

// The bytes of each row.
std::vector<uint8_t> raw_values(const Attribute& source, std::span<const uint32_t> rows);

}  // namespace psplit
