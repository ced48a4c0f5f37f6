// Containers of Draco streams for tests without an encoder: the extension's samples.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "psplit/decode.h"

namespace psplit {

struct SampleContainer {
  std::string name;
  std::vector<uint8_t> bytes;
  std::vector<AttributeRequest> requests;
};

std::vector<SampleContainer> sample_containers();

}  // namespace psplit
