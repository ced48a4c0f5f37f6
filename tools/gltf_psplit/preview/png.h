// Images as PNG files.
#pragma once

#include <cstdint>
#include <vector>

#include "src/status.h"
#include "tools/gltf_psplit/preview/camera.h"

namespace psplit {

// Rows from the top, each of `width` times red, green, blue (sRGB, not multiplied by alpha) and alpha.
struct Image {
  ImageSize size;
  std::vector<uint8_t> rgba;
};

Expected<std::vector<uint8_t>> encode_png(const Image& image);

}  // namespace psplit
