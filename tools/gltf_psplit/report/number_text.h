// Counts, shares, times and sizes as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace psplit {

std::string with_separators(uint64_t count);                   // 1,234,567
std::string with_decimals(double value, int decimals);         // 3.14; "-" if the value is not finite
std::string with_digits(double value, int digits);             // 0.00123, 1.23e-07
std::string as_percent(double fraction);                       // +3.2 %
std::string as_share(double fraction);                         // 3.2 %
std::string as_duration(double ms);                            // 12.3 ms, 4.56 s
std::string as_bytes(uint64_t bytes);                          // 12 bytes, 1.18 MB, 34.1 GB
std::string plural(const std::string& noun);                   // patches
std::string counted(uint64_t count, const std::string& noun);  // 1 patch, 2 patches

// "mesh 0, primitive 1"
std::string describe_place(uint64_t mesh, uint64_t primitive);

}  // namespace psplit
