// How much temporary space a mesh takes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "psplit/base.h"

namespace psplit {

struct ExpectedSizes {
  uint64_t points = 0, faces = 0;
  uint64_t record_bytes = 0;  // of a point
  bool is_soup = false;
};

// Tells `note` how much space the work may take and how much is free. kMayPass if that is too little, unless
// the sizes are not certain: then only the work itself can tell.
Status check_temporary_space(const ExpectedSizes& sizes, const std::filesystem::path& folder,
                             const std::function<void(const std::string&)>& note, bool is_certain = true);

// Checks the space that the parts of a mesh that is spooled already take beside the spool. Says nothing if
// there is enough.
Status check_space_of_parts(const ExpectedSizes& sizes, const std::filesystem::path& folder);

}  // namespace psplit
