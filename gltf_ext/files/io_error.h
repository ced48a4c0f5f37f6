// Failures of the system, told apart by whether they may pass.
#pragma once

#include <string>

#include "src/status.h"

namespace psplit {

// The code of a failure that may pass although neither the command nor its inputs change: a full disk, a lack
// of memory, a lock that another process holds, an interruption, a time-out. It is EX_TEMPFAIL of sysexits.h.
// StatusCode has no name for it, because only commands return it.
inline constexpr StatusCode kMayPass{75};

inline Status may_pass(std::string message, Place place = {}) {
  return {kMayPass, std::move(message), std::move(place)};
}

// "`what`: the text of `error`", for an errno. The code is kMayPass for a lack of space, memory, files or
// processes, for a stale or interrupted file system, and for a file that is busy; otherwise kIo.
Status io_error(const std::string& what, int error, Place place = {});

}  // namespace psplit
