// The output of commands that write a text or JSON, on stdout by default.
#pragma once

#include <string>

#include "gltf_ext/json/json.h"
#include "psplit/base.h"
#include "system/files.h"

namespace psplit {

// Writes the whole text or, on an error, nothing; "-" is stdout.
Status write_text(const std::string& path, const std::string& text,
                  IfReadOnly if_read_only = IfReadOnly::kFail);

// Indented JSON. Names of files need not be UTF-8, but JSON must be: other bytes become U+FFFD.
std::string report_text(const Json& report);

}  // namespace psplit
