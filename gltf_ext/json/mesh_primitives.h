// The two lists of primitives that a mesh may have.
//
// A file may give a mesh coarse primitives, which every loader shows, and in the mesh's extension the
// primitives that replace them in a loader that knows it:
//
//   {"primitives": [coarse], "extensions": {"PSPLIT_mesh_draco_patches": {"primitives": [fine]}}}
//
// In memory the lists change places: `primitives` has the fine ones, so nothing but the reader and the writer
// of a file needs to know of the others.
#pragma once

#include "gltf_ext/json/extension_names.h"
#include "gltf_ext/json/json_fields.h"
#include "psplit/base.h"

namespace psplit {

// The other list of primitives of a mesh, or null. In memory that is the list of the coarse ones.
template <AnyJson J>
J* other_primitives(J& mesh) {
  J* extension = extension_field(mesh, kExtensionName);
  return extension == nullptr ? nullptr : array_field(*extension, "primitives");
}

// Exchanges the lists of every mesh that has two, from a file to memory or back. Errors: kInvalidInput, with
// the mesh, if one of the two is not a list of objects, or is empty.
Status exchange_primitives(Json& json);

}  // namespace psplit
