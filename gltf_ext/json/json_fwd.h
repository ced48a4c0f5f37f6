// The name of the JSON tree, for headers that only pass it on. json.h has the type.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace psplit {

using Json = nlohmann::ordered_json;

}  // namespace psplit
