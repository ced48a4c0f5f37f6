// Failures of the system, told apart by whether they may pass.
#pragma once

#include <string>
#include <system_error>

#include "psplit/base.h"

namespace psplit {

inline Status may_pass(std::string message, Place place = {}) {
  return {StatusCode::kMayPass, std::move(message), std::move(place)};
}

// "`what`: the text of `error`", for an errno. The code is kOutOfMemory for a lack of memory; kMayPass for
// a lack of space, files or processes, for a stale or interrupted file system, and for a file that is busy;
// otherwise kIo.
Status io_error(const std::string& what, int error, Place place = {});
// An overload for an error of std::filesystem, which may have a number of the system.
Status io_error(const std::string& what, const std::error_code& error, Place place = {});

}  // namespace psplit
