// The kind of image in a file, by its first bytes: file names may be wrong.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace psplit {

struct ImageType {
  const char* mime_type;  // as the images of glTF and of its extensions state it
  const char* extension;  // of file names, with the dot
};

// The most bytes of a file that image_type looks at.
inline constexpr size_t kImageHeadBytes = 64;

// PNG, JPEG, WebP, KTX, KTX 2, Basis, DDS, AVIF, GIF and BMP; nothing for other content.
std::optional<ImageType> image_type(std::span<const uint8_t> head);

// Whether the header of a PNG says that its pixels are grey. False for other images.
bool is_grey_png(std::span<const uint8_t> head);

}  // namespace psplit
