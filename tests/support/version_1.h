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

// As an encoder of version 1 wrote meshes of the catalogue. Together they use all that version 1 has.
std::vector<Version1Container> version_1_containers();

// A stream's part in the format of version 1, which has pairs in the place of repeats: the map has none.
std::vector<uint8_t> write_stitch_map_1(const StitchMap& map, uint32_t patch);

}  // namespace psplit
