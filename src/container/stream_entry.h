// One row of a container's directory.
#pragma once

#include <cstdint>
#include <tuple>

namespace psplit {

struct StreamEntry {
  uint32_t stream_bytes = 0;
  uint32_t face_count = 0;
  uint32_t point_count = 0;      // as decoded, references included
  uint32_t reference_count = 0;  // points that another stream, or an earlier point of this one, owns
  uint32_t stitch_bytes = 0;
  bool is_condensed = false;  // its fields are coded with the models of the container's head
  uint8_t skeleton = 0;       // of a condensed stream: which of the head's skeletons it has

  friend bool operator==(const StreamEntry& a, const StreamEntry& b) {
    const auto members = [](const StreamEntry& of) {
      return std::tie(of.stream_bytes, of.face_count, of.point_count, of.reference_count, of.stitch_bytes,
                      of.is_condensed, of.skeleton);
    };
    return members(a) == members(b);
  }
};

}  // namespace psplit
