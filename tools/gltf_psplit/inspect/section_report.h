// Where the bytes of condensed patches are, as `inspect` prints it.
#pragma once

#include <string>

#include "tools/gltf_psplit/inspect/inspected_asset.h"

namespace psplit {

// A title and a table with a row for each section that has bytes; empty if no patch is condensed.
std::string sections_text(const InspectedPrimitive& primitive);

// {"numbers", "borders", "symbols", "seams", "ends", "stored_streams", "attributes": [{"semantic", "tokens",
// "bits", "flags"}]}, in bytes. With the directory, the head and the stitch map they sum to the container.
Json sections_json(const InspectedPrimitive& primitive);

}  // namespace psplit
