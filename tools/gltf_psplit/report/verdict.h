// What `validate` says about a file.
#pragma once

#include <span>
#include <string>

#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// The result for one file: its findings, and whether it is valid.
struct Verdict {
  std::string text;
  Json json;  // {"file", "valid", "errors", "warnings", "findings"}
  Status status;
};

// kInvalidInput if the file breaks a rule; kUnsupported if all errors concern unsupported features.
Verdict verdict_of(const std::string& input, std::span<const Finding> findings);

// Says what decode_document corrected.
void warn_of_corrections(std::span<const Finding> corrections, const Log& log, const std::string& input);

}  // namespace psplit
