// Where and with what something was measured.
#pragma once

#include <string>

namespace psplit {

struct Environment {
  std::string cpu;                                 // its model
  int threads = 1;                                 // that it runs at once
  std::string gpu;                                 // empty where there is none that this build can use
  std::string psplit, draco, meshoptimizer, zstd;  // versions
  int meshopt_codec = 0;                           // version of meshoptimizer's codec for attributes
  std::string compiler;                            // of psplit
  std::string command_line;                        // without the folders of files
  std::string date;                                // UTC, as 2026-01-31 12:00
};

// `version` and `command_line` are those of the command (Session).
Environment describe_environment(const std::string& version, const std::string& command_line);

}  // namespace psplit
