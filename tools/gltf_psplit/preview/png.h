// PNG files.
#pragma once

#include <cstdint>
#include <vector>

#include "src/status.h"
#include "tools/gltf_psplit/preview/camera.h"

namespace psplit {

// Rows from top to bottom. Each pixel is red, green, blue (sRGB, not premultiplied) and alpha.
struct Image {
  ImageSize size;
  std::vector<uint8_t> rgba;
};

Expected<std::vector<uint8_t>> encode_png(const Image& image);

}  // namespace psplit
