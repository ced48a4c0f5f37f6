// How much memory an asset will take, from the header of its file or from a sample of its lines.
#pragma once

#include <cstdint>
#include <string>

#include "tools/gltf_psplit/batch/batch_report.h"

namespace psplit {

// An estimate of the memory in bytes that a verb takes at most for the asset in a file, without that of the
// process itself. A broken file may get any estimate. The factors are in memory_estimate.cpp, and a test holds
// the estimate against measured peaks. `name`: the name that tells the format if the content does not, if it is
// not that of the path. `with_coarse`: encode makes coarse primitives as well. `known_bytes`: the size of a
// temporary file, which a system may not tell while it is open; 0 if the file tells it.
uint64_t estimate_memory(const std::string& path, BatchVerb verb, const std::string& name = "",
                         bool with_coarse = false, uint64_t known_bytes = 0);

// The memory that a process takes before it has read an asset.
inline constexpr uint64_t kProcessMemory = uint64_t{24} << 20;

}  // namespace psplit
