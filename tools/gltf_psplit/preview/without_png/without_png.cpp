// What stands for libpng in a build without it.
#include "tools/gltf_psplit/preview/picture.h"

namespace psplit {

Expected<std::vector<uint8_t>> encode_png(const Image&) {
  return wrong_usage("this psplit was built without libpng (PSPLIT_WITH_PNG=OFF)");
}

}  // namespace psplit
