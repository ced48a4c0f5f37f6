// Draws a glTF asset, with every patch in its own colour.
#pragma once

#include "gltf_ext/primitive/read_primitives.h"
#include "tools/gltf_psplit/preview/picture.h"

namespace psplit {

// Draws the default scene (preview/scene.h). A primitive that is not split has one colour. Primitives without
// triangles are left out; kUnsupported if none is left.
Expected<Image> draw_preview(const Document& document, ImageSize size, const DecodeBackend& backend,
                             const ThreadPool& pool, const Progress& progress = {});

}  // namespace psplit
