// Hostile JSON text to a tree that is safe to walk.
#pragma once

#include <string>
#include <string_view>

#include "gltf_ext/json/json.h"
#include "psplit/base.h"

namespace psplit {

// The most nested levels of arrays and objects, so that code that walks the tree may recurse.
inline constexpr int kMaxJsonDepth = 256;

// Skips a UTF-8 byte order mark. kInvalidInput if the text is not JSON or not UTF-8 (it says where), if it
// nests deeper than kMaxJsonDepth, or if an object has more members than any asset needs (their look-up is
// linear). kUnsupported for UTF-16 and UTF-32.
Expected<Json> parse_json(std::string_view text);

// JSON on one line. Bytes that are not UTF-8 become U+FFFD.
std::string json_line(const Json& json);
// The text of the JSON with a line for each value, indented by 2 spaces for each level, and without a last
// newline.
std::string json_lines(const Json& json);

// Whether a text is valid UTF-8, which JSON requires.
bool is_utf8(const std::string& text);

}  // namespace psplit
