// The geometry of glTF primitives, as meshes.
#pragma once

#include <functional>

#include "gltf_ext/primitive/accessors.h"
#include "psplit/decode.h"

namespace psplit {

// Reads the attributes and indices of a triangle primitive. `backend` decodes PSPLIT_mesh_draco_patches and
// KHR_draco_mesh_compression. Primitives without indices get 0, 1, 2 ... Strips and fans become lists. Errors:
// kInvalidInput (counts of attributes that differ, an index out of range, and others), kUnsupported (no
// triangles, no POSITION), and the backend's errors.
Expected<Mesh> read_primitive(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                              const ThreadPool& pool);

// Reads many primitives, which the backend decodes together. Returns a mesh or an error for each of `ids`.
std::vector<Expected<Mesh>> read_primitives(const Document& document, std::span<const PrimitiveId> ids,
                                            const DecodeBackend& backend, const ThreadPool& pool,
                                            const Progress& progress = {});

// Lines or points, which the extension never stores. Each face of `mesh` is an element; its first two points
// (its first point) count. Strips and loops become lists.
struct LinesOrPoints {
  int corner_count = 1;
  Mesh mesh;
};
Expected<LinesOrPoints> read_lines_or_points(const Document& document, PrimitiveId id);

// The data of one attribute of one morph target.
struct MorphAttribute {
  size_t target = 0;
  std::string semantic;
  AccessorData data;
  bool sparse = false;  // its accessor is sparse, or has no buffer view
};
// All attributes of all morph targets that accessors have, in the order of the primitive's `targets`. If
// `point_count` is given, another count is kInvalidInput. Targets in a container come with its mesh
// (name_of_target).
Expected<std::vector<MorphAttribute>> read_morph_targets(const Document& document, PrimitiveId id,
                                                         std::optional<uint32_t> point_count = {});

// Takes the morph targets that came with a mesh, in the order of its attributes.
std::vector<MorphAttribute> take_targets(Mesh& mesh);
// Makes a mesh's attribute of one.
Attribute attribute_of(MorphAttribute morph);

// The data of a compressed primitive. The document owns the bytes. Errors: kInvalidInput; kUnsupported if the
// bytes are missing (buffer_view_bytes).
struct StoredPrimitive {
  std::span<const uint8_t> bytes;  // a container, or the single stream of stock Draco
  std::vector<AttributeRequest> requests;
};
Expected<StoredPrimitive> stored_primitive(const Document& document, PrimitiveId id);

}  // namespace psplit
