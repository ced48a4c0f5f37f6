#include "system/image_type.h"

#include <algorithm>
#include <string_view>

namespace psplit {
namespace {

using namespace std::string_view_literals;

bool has_at(std::span<const uint8_t> head, size_t at, std::string_view text) {
  return head.size() >= at + text.size() &&
         std::equal(text.begin(), text.end(), head.begin() + static_cast<std::ptrdiff_t>(at),
                    [](char c, uint8_t byte) { return static_cast<uint8_t>(c) == byte; });
}

bool is_webp(std::span<const uint8_t> head) { return has_at(head, 0, "RIFF") && has_at(head, 8, "WEBP"); }

// A box "ftyp" of an ISO media file whose major brand or a compatible brand is that of AVIF.
bool is_avif(std::span<const uint8_t> head) {
  if (!has_at(head, 4, "ftyp")) return false;
  const size_t box_bytes = size_t{head[2]} << 8 | head[3];
  for (size_t at = 8; at + 4 <= std::min(box_bytes, head.size()); at += 4)
    if (has_at(head, at, "avif") || has_at(head, at, "avis")) return true;
  return false;
}

// Signature, version, and the size of the header, which is always 77.
bool is_basis(std::span<const uint8_t> head) { return has_at(head, 0, "sB") && has_at(head, 4, "\x4d\0"sv); }

// Many texts begin with "BM" too, so the size of the second header is checked: it has seven legal values.
bool is_bmp(std::span<const uint8_t> head) {
  constexpr uint8_t kSizes[] = {12, 40, 52, 56, 64, 108, 124};
  return has_at(head, 0, "BM") && has_at(head, 15, "\0\0\0"sv) &&
         std::find(std::begin(kSizes), std::end(kSizes), head[14]) != std::end(kSizes);
}

}  // namespace

std::optional<ImageType> image_type(std::span<const uint8_t> head) {
  if (has_at(head, 0, "\x89PNG\r\n\x1a\n")) return ImageType{"image/png", ".png"};
  if (has_at(head, 0, "\xff\xd8\xff")) return ImageType{"image/jpeg", ".jpg"};
  if (is_webp(head)) return ImageType{"image/webp", ".webp"};
  if (has_at(head, 0, "\xabKTX 20\xbb\r\n\x1a\n")) return ImageType{"image/ktx2", ".ktx2"};
  if (has_at(head, 0, "\xabKTX 11\xbb\r\n\x1a\n")) return ImageType{"image/ktx", ".ktx"};
  if (has_at(head, 0, "DDS \x7c\0\0\0"sv)) return ImageType{"image/vnd-ms.dds", ".dds"};
  if (is_avif(head)) return ImageType{"image/avif", ".avif"};
  if (has_at(head, 0, "GIF87a") || has_at(head, 0, "GIF89a")) return ImageType{"image/gif", ".gif"};
  if (is_basis(head)) return ImageType{"image/basis", ".basis"};
  if (is_bmp(head)) return ImageType{"image/bmp", ".bmp"};
  return std::nullopt;
}

bool is_grey_png(std::span<const uint8_t> head) {
  constexpr size_t kColorType = 25;  // in the first chunk, IHDR
  constexpr uint8_t kGrey = 0, kGreyAndAlpha = 4;
  return has_at(head, 0, "\x89PNG\r\n\x1a\n") && has_at(head, 12, "IHDR") && head.size() > kColorType &&
         (head[kColorType] == kGrey || head[kColorType] == kGreyAndAlpha);
}

}  // namespace psplit
