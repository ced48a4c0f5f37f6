// The exit codes of gltf-psplit. Each is a StatusCode.
#pragma once

#include <span>
#include <string>

#include "src/status.h"

namespace psplit {

struct ExitCode {
  StatusCode code;
  const char* meaning;
};
// All exit codes, in ascending order.
std::span<const ExitCode> exit_codes();
// All exit codes as --help prints them, under a heading, in lines of at most `width` columns.
std::string exit_codes_help(size_t width);

}  // namespace psplit
