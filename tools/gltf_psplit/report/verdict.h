// What `validate` says about a file.
#pragma once

#include <span>
#include <string>

#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json.h"

namespace psplit {

// The result for one file: its findings, and whether it is valid.
struct Verdict {
  std::string text;
  Json json;  // {"file", "valid", "errors", "warnings", "findings"}
  Status status;
};

// kInvalidInput if the file breaks a rule; kUnsupported if all errors concern unsupported features.
Verdict verdict_of(const std::string& input, std::span<const Finding> findings);

}  // namespace psplit
