// Containers of version 1, which encoders no longer write and decoders still read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "encoder/stitching/stitch_map.h"
#include "src/container/decode_backend.h"

namespace psplit {

struct Version1Container {
  std::string name;
  std::vector<uint8_t> bytes;
  std::vector<AttributeRequest> requests;  // all attributes
};

// Meshes of the catalogue as an encoder of version 1 wrote them. Together they use all features of version 1.
std::vector<Version1Container> version_1_containers();

// The part of one stream in the format of version 1. That format has pairs instead of repeats, so `map` must
// not have repeats.
std::vector<uint8_t> write_stitch_map_1(const StitchMap& map, uint32_t patch);

}  // namespace psplit
