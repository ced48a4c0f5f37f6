// What every subcommand runs with.
#pragma once

#include <string>
#include <utility>

#include "psplit/parallel.h"
#include "system/files.h"
#include "tools/gltf_psplit/report/log.h"

namespace psplit {

// Made from the options -q, -v, -j and --force.
struct Session {
  Log log;
  ThreadPool pool;
  std::string version;       // of the command
  std::string command_line;  // quoted for a shell, without the folders of files: for reports
  bool force = false;        // the output may replace its input, and a read-only file
  IfReadOnly if_read_only() const { return force ? IfReadOnly::kReplace : IfReadOnly::kFail; }
  Session(Verbosity verbosity, int thread_count, std::string its_version = "",
          std::string its_command_line = "")
      : log(verbosity),
        pool(thread_count),
        version(std::move(its_version)),
        command_line(std::move(its_command_line)) {}
};

}  // namespace psplit
