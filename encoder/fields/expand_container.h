// Condensed streams of a container become the Draco streams that they were made from.
#pragma once

#include "encoder/fields/section_bytes.h"
#include "psplit/parallel.h"
#include "src/container/patch_container.h"

namespace psplit {

// The Draco stream of a patch, or of the residue. A stored stream is copied. Errors: as for expand_stream,
// with the patch as their place.
Expected<std::vector<uint8_t>> expand_patch(const PatchContainer& container, uint32_t patch);

// A container of Draco streams with the same mesh, numbering and stitch map. Errors: as for expand_patch.
Expected<std::vector<uint8_t>> expand_container(const PatchContainer& container, const ThreadPool& pool);

// Where the bytes of all condensed streams are. Attributes have the places that they have in the streams.
// Errors: as for expand_patch.
Expected<SectionBytes> measure_sections(const PatchContainer& container, const ThreadPool& pool);

}  // namespace psplit
