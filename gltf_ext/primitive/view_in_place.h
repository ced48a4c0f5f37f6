// Primitives whose accessors can be used as they are, without a copy in memory.
#pragma once

#include <optional>

#include "gltf_ext/primitive/mesh_view.h"

namespace psplit {

// The attributes and indices of a plain primitive in the document's buffers. Nothing if it must be read
// (read_primitive): it is no triangle list with indices, an accessor is sparse or padded, or it is invalid. The
// values of indices are not checked.
std::optional<MeshView> view_in_place(const Document& document, PrimitiveId id);

// Whether all indices of such a view are below the number of points, and are not the value that restarts
// primitives. Reads them in steps.
bool has_valid_indices(const MeshView& view);

}  // namespace psplit
