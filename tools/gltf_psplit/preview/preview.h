// A glTF asset as a picture, every patch in its own colour.
#pragma once

#include "gltf_ext/primitive/read_primitives.h"
#include "tools/gltf_psplit/preview/png.h"

namespace psplit {

// The default scene (preview/scene.h), in patches where primitives are split and in one colour a primitive
// where they are not. What has no triangles is left out; kUnsupported where nothing is left.
Expected<Image> draw_preview(const Document& document, ImageSize size, const DecodeBackend& backend,
                             const ThreadPool& pool, const Progress& progress = {});

}  // namespace psplit
