// The exit codes of gltf-psplit, each with its StatusCode. Reports have them as the codes of errors, too.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "psplit/base.h"

namespace psplit {

struct ExitCode {
  int number;
  StatusCode code;
  const char* meaning;
};
// All exit codes, in ascending order.
std::span<const ExitCode> exit_codes();
// The number of a status. No command ends with kCancelled: it is kRuntimeFailure's.
int exit_code(StatusCode code);
// The status of a number in a report. kRuntimeFailure for a number that no code has.
StatusCode status_code(int64_t number);
// All exit codes as --help prints them, under a heading, in lines of at most `width` columns.
std::string exit_codes_help(size_t width);

}  // namespace psplit
