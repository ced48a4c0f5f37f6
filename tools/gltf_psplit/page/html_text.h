// Building blocks of HTML.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace psplit {

// Escapes any bytes as the text of an element or of a quoted attribute. Control characters become U+FFFD.
std::string escape_html(std::string_view text);

// "<td class="x">text</td>". The text is escaped; the tag and the attributes are not.
std::string html_element(const std::string& tag, std::string_view text, const std::string& attributes = "");

// Puts markup that may be wider than the window into a region that scrolls sideways. A line above it says so on
// phones, and if it is wide, on tablets too.
std::string scrolling_region(std::string_view label, bool is_wide, const std::string& markup);

// Base64, for data URIs.
std::string base64(std::span<const uint8_t> bytes);

}  // namespace psplit
