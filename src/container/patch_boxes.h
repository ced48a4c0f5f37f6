// The boxes of patches: a section of the head that readers may skip. A viewer knows by them what to ask for
// first. Specification: "boxes" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/mesh.h"
#include "src/container/patch_container.h"

namespace psplit {

// One for each stream; none if the container has no boxes. Errors: kInvalidInput for a section of a wrong
// length or without finite bounds.
Expected<std::vector<PatchBox>> patch_boxes(const PatchContainer& container);

// The section's bytes as they are stored, in the container's bytes; empty if there is none.
std::span<const uint8_t> boxes_section(const PatchContainer& container);

// A box without positions.
PatchBox no_box();
// Adds a position of three components to a box. One that is not finite is in no box.
void extend(PatchBox& box, const std::byte* position, ComponentType type, bool normalized);
// The first axis on which positions, whose box is `positions`, are outside of `box`; nothing if it has all of
// them. The rounding of the box's own bounds does not count.
std::optional<size_t> axis_outside(const PatchBox& box, const PatchBox& positions);

// The range of a mesh's faces and points that belong to one stream: its faces, and the points that it owns.
struct StreamPlace {
  size_t first_face = 0, end_face = 0;
  uint32_t first_point = 0, end_point = 0;
};
StreamPlace place_of_stream(const PatchContainer& container, uint32_t stream);

// The box of a stream. point_at(corner) is the point at a corner of the mesh, three for each face, and
// position_at(point) its stored position.
template <typename PointAt, typename PositionAt>
PatchBox box_of(const StreamPlace& place, ComponentType type, bool normalized, const PointAt& point_at,
                const PositionAt& position_at) {
  PatchBox box = no_box();
  for (size_t corner = 3 * place.first_face; corner < 3 * place.end_face; ++corner)
    extend(box, position_at(point_at(corner)), type, normalized);
  for (uint32_t point = place.first_point; point < place.end_point; ++point)
    extend(box, position_at(point), type, normalized);
  return box;
}

// A box for each stream of a container that decodes to this mesh; none if it has no positions of three
// components.
std::vector<PatchBox> boxes_of(const PatchContainer& container, const Mesh& decoded);

// The content of the section; empty if no box has a position.
std::vector<uint8_t> write_boxes(std::span<const PatchBox> boxes);

}  // namespace psplit
