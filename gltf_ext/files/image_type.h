// What kind of image a file holds, by its first bytes: names lie.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace psplit {

struct ImageType {
  const char* mime_type;  // as glTF's and its extensions' images name it
  const char* extension;  // of file names, with the dot
};

// Bytes of a file that image_type looks at, at most.
inline constexpr size_t kImageHeadBytes = 64;

// PNG, JPEG, WebP, KTX, KTX 2, Basis, DDS, AVIF, GIF and BMP; nothing for all else.
std::optional<ImageType> image_type(std::span<const uint8_t> head);

}  // namespace psplit
