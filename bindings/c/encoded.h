// The handles of an encoded mesh, and of bytes that the library made for the caller.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "psplit/decode.h"
#include "psplit/mesh.h"
#include "psplit/psplit.h"

struct psplit_encoded {
  // How an attribute is stored, and why; the bounds of its decoded values.
  struct Storage {
    int bits = 0;
    float range = 0;
    std::vector<float> origin{};
    std::string reason{};
    psplit::ValueBounds bounds{};
  };

  psplit_kind kind = PSPLIT_KIND_NONE;
  std::vector<uint8_t> bytes{};
  std::vector<psplit::AttributeRequest> requests{};
  std::vector<Storage> storage{};  // of each request
  std::vector<uint32_t> source_points{};
  std::vector<std::string> notes{};
  uint32_t face_count = 0, patch_count = 1;
  double position_error = -1;
};

struct psplit_output {
  std::vector<uint8_t> bytes{};
};
