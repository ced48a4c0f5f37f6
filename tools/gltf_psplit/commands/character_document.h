// A generated character as a glTF asset.
#pragma once

#include "psplit/document.h"
#include "tools/gltf_psplit/shapes/character.h"

namespace psplit {

// One mesh with its morph targets on a node with a skin, the nodes of its joints, and the clip. Targets are
// plain accessors, as exporters write them.
Document character_document(const Character& character);

}  // namespace psplit
