// Checks a glTF tree, so that its indices may be followed.
#pragma once

#include "gltf_ext/json/json.h"
#include "src/status.h"

namespace psplit {

// Checks the version, the kinds of the top-level members, required members, types of attributes, every index
// of an accessor, buffer view or buffer, and every extent against the lengths that the JSON states; and
// check_scene. Unknown members are allowed. Errors: kInvalidInput, kUnsupported (another version of glTF).
Status check_structure(const Json& json);

}  // namespace psplit
