// What encoding changes in the JSON of an asset, in bytes. A primitive of few faces has more JSON than data:
// its buffer views go, and an extension comes.
#pragma once

#include <cstdint>
#include <span>

#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/primitive/geometry_bytes.h"

namespace psplit {

// By how many bytes the JSON of a GLB grows if these jobs, which are encoded, are stored; negative if it gets
// shorter. The lists of extensions are not counted. The number is near to what is written: it is not known
// which digits numbers of new objects have.
int64_t json_growth(const Document& document, const GeometryOwners& owners,
                    std::span<const EncodeJob* const> jobs);

// The bytes that the name takes in the document's lists of used and required extensions, if it is not there.
int64_t list_growth(const Document& document, const char* extension);

}  // namespace psplit
