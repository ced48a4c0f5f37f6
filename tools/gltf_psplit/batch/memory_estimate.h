// How much memory an asset will take, from the header of its file or from a sample of its lines.
#pragma once

#include <cstdint>
#include <string>

#include "gltf_ext/convert/memory_model.h"
#include "tools/gltf_psplit/batch/batch_report.h"

namespace psplit {

// An estimate of the memory in bytes that a verb takes at most for the asset in a file, without that of the
// process itself. A broken file may get any estimate. memory_model.h has the numbers. `name`: the
// name that tells the format if the content does not, if it is not that of the path. `with_coarse`: encode
// makes coarse primitives as well. `known_bytes`: the size of a temporary file, which a system may not tell
// while it is open; 0 if the file tells it.
uint64_t estimate_memory(const std::string& path, BatchVerb verb, const std::string& name = "",
                         bool with_coarse = false, uint64_t known_bytes = 0);
// Estimates the memory of a glTF asset that is already read.
uint64_t estimate_memory(const Document& document, BatchVerb verb, bool with_coarse);

}  // namespace psplit
