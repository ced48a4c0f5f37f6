// Numbers with a point from text, in any locale.
#pragma once

#include <charconv>

namespace psplit {

// std::from_chars, which libc++ has for floats only from version 20 on.
std::from_chars_result read_float(const char* begin, const char* end, float& value);
std::from_chars_result read_float(const char* begin, const char* end, double& value);

// What these do without it, slowly. A number whose nearest value would be subnormal may be out of range.
std::from_chars_result read_float_by_stream(const char* begin, const char* end, float& value);
std::from_chars_result read_float_by_stream(const char* begin, const char* end, double& value);

}  // namespace psplit
