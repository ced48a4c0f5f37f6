// Primitives whose accessors can be used as they are, without a copy in memory.
#pragma once

#include <optional>
#include <span>

#include "gltf_ext/primitive/mesh_view.h"

namespace psplit {

// The attributes and indices of a plain triangle list in the document's buffers. Without an accessor of
// indices, they have a count but no bytes: they are 0, 1, 2 and so on. Values are not checked. Errors:
// kUnsupported if the primitive must be read (read_primitive): it is compressed, a strip or a fan, or an
// accessor is sparse or padded; and errors of read_primitive.
Expected<MeshView> view_in_place(const Document& document, PrimitiveId id);

// As above, if it has an accessor of indices that read_indices accepts; nothing if it must be read or is
// invalid.
std::optional<MeshView> valid_view_in_place(const Document& document, PrimitiveId id);

// Widens as many indices of a primitive, from `first` on, as `to` has room for. Errors: kInvalidInput if one is
// not below the number of points, or is the value that restarts primitives.
Status read_indices(const ValuesView& indices, size_t first, uint32_t point_count, std::span<uint32_t> to);

}  // namespace psplit
