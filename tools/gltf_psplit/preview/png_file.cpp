#include <png.h>

#include <string>

#include "tools/gltf_psplit/preview/picture.h"

namespace psplit {

Expected<std::vector<uint8_t>> encode_png(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.size.width);
  header.height = static_cast<png_uint_32>(image.size.height);
  header.format = PNG_FORMAT_RGBA;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<uint8_t> file(bytes);
  if (png_image_write_to_memory(&header, file.data(), &bytes, 0, image.rgba.data(), 0, nullptr) == 0)
    return runtime_failure(std::string("libpng: ") + header.message);
  file.resize(bytes);
  return file;
}

}  // namespace psplit
