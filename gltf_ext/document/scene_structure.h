// What must hold of a glTF tree for loaders to follow what psplit itself passes through.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// Every index of a node, mesh, skin, camera, material, texture, image, sampler or scene names one that exists;
// no node is below itself; skins have joints, and as many inverse bind matrices. What is unknown is allowed.
Status check_scene(const Json& json);

}  // namespace psplit
