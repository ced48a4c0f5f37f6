// The boxes of patches: a section of the head that readers may skip. A viewer knows by them what to ask for
// first. Specification: "boxes" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/container/decode_backend.h"
#include "src/container/patch_container.h"
#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

// One for each stream; none if the container has no boxes. Errors: kInvalidInput for a section of a wrong
// length or without finite bounds.
Expected<std::vector<PatchBox>> patch_boxes(const PatchContainer& container);

// The section's bytes as they are stored, in the container's bytes; empty if there is none.
std::span<const uint8_t> boxes_section(const PatchContainer& container);

// The container with boxes in its head. `decoded` is what it decodes to. Returns it as it is if it has no
// positions of three components.
std::vector<uint8_t> with_boxes(const PatchContainer& container, const Mesh& decoded);

}  // namespace psplit
