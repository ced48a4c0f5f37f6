// .drc files: one Draco mesh stream as a document.
#pragma once

#include "gltf_ext/document/document.h"
#include "src/container/stream_description.h"

namespace psplit {

// Whether bytes begin as every Draco stream does.
bool is_draco(std::span<const uint8_t> bytes);

// A document of one node whose primitive holds the stream as it is, as KHR_draco_mesh_compression; attributes
// are those of gltf_attributes. `describe` is asked once; nothing else decodes the stream. Errors: those of
// `describe` and of gltf_attributes, and kUnsupported for point clouds.
Expected<Document> document_from_draco(std::span<const uint8_t> stream, const DescribeStream& describe);

}  // namespace psplit
