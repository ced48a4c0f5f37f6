// How much memory work on one primitive takes.
#pragma once

#include <cstdint>
#include <filesystem>

namespace psplit {

// Primitives that fit are in memory as a whole. Larger ones are decoded window by window into a temporary file
// without a name.
struct MemoryLimit {
  uint64_t bytes = 0;  // 0: no limit
  std::filesystem::path folder = ".";

  bool allows(uint64_t needed) const { return bytes == 0 || needed <= bytes; }
};

}  // namespace psplit
