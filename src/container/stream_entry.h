// One row of a container's directory.
#pragma once

#include <cstdint>

namespace psplit {

struct StreamEntry {
  uint32_t stream_bytes = 0;
  uint32_t face_count = 0;
  uint32_t point_count = 0;      // as decoded, references included
  uint32_t reference_count = 0;  // points that another stream, or an earlier point of this one, owns
  uint32_t stitch_bytes = 0;
  bool is_condensed = false;  // its fields are coded with the models of the container's head
  uint8_t skeleton = 0;       // of a condensed stream: which of the head's skeletons it has
  bool operator==(const StreamEntry&) const = default;
};

}  // namespace psplit
