// What encoding changes in the JSON of an asset, in bytes. A primitive of few faces has more JSON than data:
// its buffer views go, and an extension comes.
#pragma once

#include <cstdint>
#include <span>

#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/primitive/geometry_bytes.h"

namespace psplit {

// The number of bytes by which the JSON of a GLB grows if these encoded jobs are stored; negative if it becomes
// shorter. The lists of extensions are not counted. The number is an estimate, because the digits of new
// objects' indices are unknown.
int64_t json_growth(const Document& document, const GeometryOwners& owners,
                    std::span<const EncodeJob* const> jobs);

// The bytes that the name takes in the document's lists of used and required extensions, if it is not there.
int64_t list_growth(const Document& document, const char* extension);

}  // namespace psplit
