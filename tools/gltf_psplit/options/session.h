// What every subcommand runs with.
#pragma once

#include <string>
#include <utility>

#include "src/parallel.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// Made from the options -q, -v and -j.
struct Session {
  Log log;
  ThreadPool pool;
  std::string version;       // of the command
  std::string command_line;  // quoted for a shell, without the folders of files: for reports
  Session(Verbosity verbosity, int thread_count, std::string its_version = "",
          std::string its_command_line = "")
      : log(verbosity),
        pool(thread_count),
        version(std::move(its_version)),
        command_line(std::move(its_command_line)) {}
};

}  // namespace psplit
