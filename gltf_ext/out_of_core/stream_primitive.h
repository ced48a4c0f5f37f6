// A plain triangle primitive of any size, read by windows of its accessors.
#pragma once

#include <cstdint>

#include "gltf_ext/document/document.h"
#include "gltf_ext/mesh_files/mesh_file.h"

namespace psplit {

struct PrimitiveSize {
  uint64_t points = 0, faces = 0;
  uint64_t record_bytes = 0;  // of a point
};

// What the accessors state. Zeros for what they do not state.
PrimitiveSize stated_size(const Document& document, PrimitiveId id);

// Passes the points and faces of a triangle list to `sink`. Memory of mapped buffers is released after each
// window. Errors: those of the sink and of read_primitive, and kUnsupported for what is not read so: strips and
// fans, compressed primitives, morph targets, skins, sparse accessors, padded matrices, 32-bit integers, and
// positions that are not floats.
Status stream_primitive(const Document& document, PrimitiveId id, MeshSink& sink);

}  // namespace psplit
