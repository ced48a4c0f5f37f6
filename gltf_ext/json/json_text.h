// JSON text that may be hostile to a tree that is safe to walk.
#pragma once

#include <string_view>

#include "gltf_ext/json/json.h"
#include "src/status.h"

namespace psplit {

// Levels of arrays and objects: code that walks the tree may recurse.
inline constexpr int kMaxJsonDepth = 256;

// Tolerates a UTF-8 byte order mark. Refuses text that is no JSON or no UTF-8, that nests deeper than
// kMaxJsonDepth, and objects of more members than any asset has (their look-up is linear).
Expected<Json> parse_json(std::string_view text);

}  // namespace psplit
