// Sequential streams: faces as the numbers of their points, and values in the order of points.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stream/encode_attributes.h"
#include "psplit/base.h"

namespace psplit {

// The stream that libdraco's encoder writes at this speed, 0 to 10. It keeps the order of points and faces, and
// takes any face. Indices, points of the part, are compressed if that makes the stream smaller, and if
// libdraco's decoder takes it: it refuses compressed indices of fewer than three bytes for each face in what
// follows. Errors: kInvalidInput for no points; as encode_attributes. Thread-safe.
//
// With labels (StreamTraits) indices are not compressed, as in libdraco unless it is told to.
Expected<std::vector<uint8_t>> write_sequential_stream(const AttributeSource& source,
                                                       std::span<const std::array<uint32_t, 3>> faces,
                                                       int speed, std::span<const DracoLabel> labels = {});

// Writes points without faces: a point cloud.
Expected<std::vector<uint8_t>> write_sequential_cloud(const AttributeSource& source, int speed,
                                                      std::span<const DracoLabel> labels = {});

}  // namespace psplit
