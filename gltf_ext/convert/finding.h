// A broken rule of PSPLIT_mesh_draco_patches.
#pragma once

#include <span>
#include <string>

#include "src/status.h"

namespace psplit {

struct Finding {
  std::string rule;  // stable: see the table in validate.cpp
  std::string message;
  Place place;
  bool error = true;  // otherwise a warning
  // Or kUnsupported: this decoder cannot tell whether it is valid. All other codes are of failures that say
  // nothing about the asset, such as a full disk.
  StatusCode code = StatusCode::kInvalidInput;
};

// The first failure that kept a check from its end; ok if there is none.
inline Status first_failure(std::span<const Finding> findings) {
  for (const Finding& finding : findings)
    if (finding.error && finding.code != StatusCode::kInvalidInput && finding.code != StatusCode::kUnsupported)
      return {finding.code, finding.message, finding.place};
  return {};
}

}  // namespace psplit
