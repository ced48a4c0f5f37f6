// Checks the parts of a glTF tree that psplit only passes through, so that loaders can follow their indices.
#pragma once

#include "gltf_ext/json/json.h"
#include "src/status.h"

namespace psplit {

// Checks that every index of a node, mesh, skin, camera, material, texture, image, sampler or scene names one
// that exists, that no node is its own descendant, and that every skin has joints, with as many inverse bind
// matrices. Unknown members are allowed. Errors: kInvalidInput.
Status check_scene(const Json& json);

}  // namespace psplit
