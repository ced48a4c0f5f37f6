// A glTF triangle primitive to a psplit mesh and back.
#pragma once

#include <functional>

#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/primitive_id.h"
#include "gltf_ext/primitive/accessors.h"
#include "src/container/decode_backend.h"

namespace psplit {

enum class PrimitiveStorage { kPlain, kPatches, kStockDraco };

// What a primitive is, before any of its data is read.
struct PrimitiveKind {
  PrimitiveStorage storage = PrimitiveStorage::kPlain;
  bool triangles = false;  // mode 4, 5 or 6 (strips and fans become lists)
};
Expected<PrimitiveKind> primitive_kind(const Document& document, PrimitiveId id);

// Reads attributes and indices into a mesh, decoding PSPLIT_mesh_draco_patches and KHR_draco_mesh_compression
// with `backend`. Non-indexed primitives get indices 0, 1, 2 ... Strips and fans become lists. Attributes whose
// accessors differ in count are kInvalidInput, as is an index out of range.
Expected<Mesh> read_primitive(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                              const ThreadPool& pool);

// Many at once, for backends that decode many at once. A mesh or an error for each of `ids`.
std::vector<Expected<Mesh>> read_primitives(const Document& document, std::span<const PrimitiveId> ids,
                                            const DecodeBackend& backend, const ThreadPool& pool,
                                            const Progress& progress = {});

// Lines and points, which the extension has nothing to do with: of each element its points, of which the first
// two or the first one count. Strips and loops become lists.
struct LinesOrPoints {
  int corner_count = 1;
  Mesh mesh;
};
Expected<LinesOrPoints> read_lines_or_points(const Document& document, PrimitiveId id);

// One array per morph target and semantic, in the order of the primitive's `targets`: each entry is the
// accessor that holds it and its data. Empty without morph targets.
struct MorphAttribute {
  size_t target = 0;
  std::string semantic;
  AccessorData data;
  bool sparse = false;  // its accessor is sparse, or all zero for want of a buffer view
};
Expected<std::vector<MorphAttribute>> read_morph_targets(const Document& document, PrimitiveId id,
                                                         std::optional<uint32_t> point_count = {});

// What one of the two extensions stores of a primitive, for inspection and validation. The document keeps the
// bytes. Errors: kInvalidInput.
struct StoredPrimitive {
  std::span<const uint8_t> bytes;  // a container, or the one stream of stock Draco
  std::vector<AttributeRequest> requests;
};
Expected<StoredPrimitive> stored_primitive(const Document& document, PrimitiveId id,
                                           const char* extension_name);

}  // namespace psplit
