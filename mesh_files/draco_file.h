// A .drc file, which is one Draco stream, as a document.
#pragma once

#include <functional>
#include <span>

#include "gltf_ext/document/document.h"
#include "mesh_files/mesh_file.h"
#include "psplit/decode.h"
#include "psplit/mesh.h"

namespace psplit {

// Whether bytes begin with the magic of Draco.
bool is_draco(std::span<const uint8_t> bytes);

// Decodes a point cloud to a mesh without faces, and describes it: decode_draco (psplit/decode.h) does.
using DecodePoints = std::function<Expected<Mesh>(std::span<const uint8_t> stream, StreamDescription&)>;

// A document of one node. Its primitive holds the unchanged stream as KHR_draco_mesh_compression, with the
// attributes of gltf_attributes, and the names of take_names. What its metadata say are the extras of the mesh
// and of its accessors. `describe` is called once; the stream is not decoded otherwise, unless it has values of
// types that only become floats. `losses` gets what glTF cannot hold, unless it is null. Errors: as for
// `describe` and gltf_attributes, and kUnsupported for point clouds. If `decode_points` is not empty, the
// document of a point cloud has a plain primitive of points, and Document::cloud. Errors are then as for
// `decode_points`, and kUnsupported for a cloud without points, which glTF cannot hold.
Expected<Document> document_from_draco(std::span<const uint8_t> stream, const DescribeStream& describe,
                                       const DecodePoints& decode_points = {}, Losses* losses = nullptr);

}  // namespace psplit
