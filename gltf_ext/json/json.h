// The JSON tree of a glTF document. Objects keep their members in the order of the file.
#pragma once

#include <nlohmann/json.hpp>

namespace psplit {

using Json = nlohmann::ordered_json;

}  // namespace psplit
