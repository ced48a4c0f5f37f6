// Coarse primitives, which loaders without the extension show (gltf_ext/json/mesh_primitives.h).
#pragma once

#include <cstdint>
#include <vector>

#include "gltf_ext/document/document.h"
#include "psplit/decode.h"

namespace psplit {

// Gives each mesh with compressed primitives coarse ones in their place, of about `share` of the faces, but at
// least kLeastCoarseFaces or, if that is less, a tenth of them. They have
// the same materials and attributes. Their points are points of the decoded mesh, with morph targets.
// Primitives that are uncompressed or cannot be decoded are equal in both lists; a primitive that becomes too
// small is left out. Meshes of equal geometry share the data. Replaces existing coarse primitives, and then
// updates the list of required extensions. After an error the document is unusable. Errors: kUnsupported (a
// mesh of 2^32 points), and the errors of reading primitives.
Status add_coarse_primitives(Document& document, double share, const DecodeBackend& backend,
                             const ThreadPool& pool);

// Removes the coarse primitives from the JSON of all meshes. Returns their accessors, which may have no user
// now (drop_unused). The lists of extensions stay.
std::vector<int64_t> take_coarse_primitives(Document& document);

// Removes them with their data, and says which extensions are required.
void drop_coarse_primitives(Document& document);

// What the coarse primitives of a document have. Meshes that share data count once.
struct CoarseCounts {
  uint64_t primitives = 0, faces = 0, points = 0;
  uint64_t bytes = 0;  // of accessors that nothing else uses
};
CoarseCounts coarse_counts(const Document& document);

}  // namespace psplit
