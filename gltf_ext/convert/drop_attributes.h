// Data that is left out: attributes that the user does not want, and what encoding would make wrong.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/json/json.h"
#include "psplit/gltf.h"

namespace psplit {

struct DroppedAttributes {
  std::map<PrimitiveId, std::vector<std::string>> of_primitive;
  std::vector<int64_t> freed;  // accessors that may have no user now: see PrimitiveEditor::release
  // Of primitives of which only unused attributes were dropped, the JSON before. One that is compressed and is
  // not encoded again has to keep them.
  std::map<PrimitiveId, Json> before;
  // The unused attributes of other primitives that have a material.
  std::map<PrimitiveId, std::vector<std::string>> unused;

  std::vector<std::string> of(PrimitiveId id) const {
    const auto found = of_primitive.find(id);
    return found == of_primitive.end() ? std::vector<std::string>() : found->second;
  }
};

// Removes the attributes of options.skip, and for kUnusedAttributes all that nothing reads, from the
// primitives, from their morph targets and from what their Draco extension lists; the stream itself keeps them
// until the primitive is encoded again. kUsage, and an unusable document, if the asset needs one of them:
// POSITION, coordinates of a texture, a skin, a feature id, metadata, a set that another set follows, all that
// a morph target has; or if it is in patches that stay.
Expected<DroppedAttributes> drop_attributes(Document& document, const EncodeDocumentOptions& options,
                                            std::span<const PrimitiveId> ids);

// Drops EXT_mesh_manifold from the meshes of all jobs, because it names points by indices, which change.
// Releases its accessors, and adds a warning to the report of each primitive.
void drop_manifolds(Document& document, std::span<const EncodeJob> jobs, PrimitiveEditor& editor,
                    EncodeReports& reports);

}  // namespace psplit
