// What stands before text in UTF-8, and text in other encodings.
#pragma once

#include <string_view>

#include "psplit/base.h"

namespace psplit {

// The mark that some programs write before UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
std::string_view without_byte_order_mark(std::string_view text);

// Errors: kUnsupported if the bytes begin as text in UTF-16 or UTF-32 does: with a byte order mark or without,
// and with characters of ASCII.
Status check_text_encoding(std::string_view head);

}  // namespace psplit
