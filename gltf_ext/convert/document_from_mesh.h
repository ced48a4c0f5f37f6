// A mesh as a document.
#pragma once

#include "gltf_ext/document/document.h"
#include "src/export.h"
#include "src/mesh/mesh.h"

namespace psplit {

// One scene, one node, one mesh, one plain primitive.
PSPLIT_EXPORT Document document_from_mesh(const Mesh& mesh);

}  // namespace psplit
