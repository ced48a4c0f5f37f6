// The values of a stream's first attribute at its border, which neighbouring streams share: each is stored
// once, by the stream that owns it. Specification: "border parts".
#pragma once

#include "encoder/condensing/source_stream.h"
#include "src/container/patch_container.h"

namespace psplit {

struct BorderPart {
  // The values by place of the border walk, one component after the other.
  std::vector<int32_t> values;
  std::vector<uint8_t> is_own;  // no run of the stream's stitch map has it
  // The vertices of the first attribute's table on the walk, each once.
  std::vector<uint32_t> known;
  // The symbols of the stream's own places: the first value, then differences.
  std::vector<uint32_t> symbols;

  // Whether the stream's places that others own have the others' values. `parts` are by stream.
  bool agrees(const PatchContainer& draco, uint32_t stream, uint32_t components,
              std::span<const BorderPart> parts) const;
};

BorderPart make_border_part(const DecodedSource& source, const PatchContainer& draco, uint32_t stream,
                            uint32_t components);

}  // namespace psplit
