// A .drc file, which is one Draco mesh stream, as a document.
#pragma once

#include "gltf_ext/document/document.h"
#include "src/container/stream_description.h"

namespace psplit {

// Whether bytes begin with the magic of Draco.
bool is_draco(std::span<const uint8_t> bytes);

// A document of one node. Its primitive holds the unchanged stream as KHR_draco_mesh_compression, with the
// attributes of gltf_attributes. `describe` is called once; the stream is not decoded otherwise. Errors: those
// of `describe` and gltf_attributes, and kUnsupported for point clouds.
Expected<Document> document_from_draco(std::span<const uint8_t> stream, const DescribeStream& describe);

}  // namespace psplit
