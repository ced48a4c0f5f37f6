// A broken rule of PSPLIT_mesh_draco_patches.
#pragma once

#include <string>

#include "src/status.h"

namespace psplit {

struct Finding {
  std::string rule;  // stable: see the table in validate.cpp
  std::string message;
  Place place;
  bool error = true;                            // otherwise a warning
  StatusCode code = StatusCode::kInvalidInput;  // or kUnsupported: this decoder cannot tell whether it is valid
};

}  // namespace psplit
