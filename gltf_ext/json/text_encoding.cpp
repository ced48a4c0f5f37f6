#include "gltf_ext/json/text_encoding.h"

#include <algorithm>
#include <cstddef>
#include <string>

namespace psplit {
namespace {

bool is_ascii_text(char c) { return (c >= ' ' && c <= '~') || c == '\t' || c == '\n' || c == '\r'; }

// Whether the first `count` units are characters of ASCII, each in `width` bytes.
bool begins_with_ascii(std::string_view text, size_t width, bool big_endian, size_t count) {
  if (text.size() < width * count) return false;
  for (size_t i = 0; i < width * count; ++i) {
    const bool holds_character = i % width == (big_endian ? width - 1 : 0);
    if (holds_character ? !is_ascii_text(text[i]) : text[i] != '\0') return false;
  }
  return true;
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view text) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return text;
}

Status check_text_encoding(std::string_view head) {
  constexpr size_t kUnmarked = 4;  // characters that tell an encoding without its mark
  for (const size_t width : {size_t{4}, size_t{2}})
    for (const bool big_endian : {false, true}) {
      std::string mark(width, '\0');
      mark[big_endian ? width - 2 : 0] = big_endian ? '\xFE' : '\xFF';
      mark[big_endian ? width - 1 : 1] = big_endian ? '\xFF' : '\xFE';
      const bool is_marked = head.starts_with(mark);
      if (begins_with_ascii(is_marked ? head.substr(width) : head, width, big_endian,
                            is_marked ? 1 : kUnmarked))
        return unsupported("text in " + std::string(width == 2 ? "UTF-16" : "UTF-32") +
                           ", and only UTF-8 is read: save it as UTF-8");
    }
  return {};
}

}  // namespace psplit
