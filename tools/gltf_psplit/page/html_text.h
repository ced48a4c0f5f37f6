// Text in HTML.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace psplit {

// Any bytes as text of an element, or of an attribute in quotes; control characters become U+FFFD.
std::string escape_html(std::string_view text);

// "<td class="x">text</td>": the text is escaped, tag and attributes are taken as they are.
std::string html_element(const std::string& tag, std::string_view text, const std::string& attributes = "");

// Markup that may be wider than its place, as a region that scrolls sideways; a line above it says so where the
// page shows the class "<kind>-hint".
std::string scrolling_region(const std::string& kind, std::string_view label, const std::string& markup);

// As data URIs want it.
std::string base64(std::span<const uint8_t> bytes);

}  // namespace psplit
