// The machine and the versions that something was measured with.
#pragma once

#include <string>

namespace psplit {

struct Environment {
  std::string cpu;                                 // the model
  int threads = 1;                                 // hardware threads
  std::string gpu;                                 // empty if there is none that this build can use
  std::string psplit, draco, meshoptimizer, zstd;  // versions
  int meshopt_codec = 0;                           // version of meshoptimizer's attribute codec
  std::string compiler;                            // that built psplit
  std::string command_line;                        // without the folders of files
  std::string date;                                // UTC, such as 2026-01-31 12:00
};

// `version` and `command_line` are those of the command (Session).
Environment describe_environment(const std::string& version, const std::string& command_line);

}  // namespace psplit
