// Whether a file can be written, asked before the work whose result it is to hold.
#pragma once

#include <string>

#include "src/status.h"

namespace psplit {

// kIo where `path` is a folder, or lies in one that is missing or may not be written. "-", devices and pipes
// pass.
Status check_output_place(const std::string& path);

// The same, and kUsage for a name that write_document does not take: .glb, .gltf and "-" only.
Status check_output_path(const std::string& path);

}  // namespace psplit
