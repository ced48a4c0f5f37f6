// The GLB container: a header, a JSON chunk, at most one binary chunk.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/status.h"

namespace psplit {

struct GlbChunks {
  std::span<const uint8_t> json;
  std::optional<std::span<const uint8_t>> binary;
};

bool is_glb(std::span<const uint8_t> file);

// The spans point into `file`. Unknown chunks and bytes past the stated length are passed over.
Expected<GlbChunks> parse_glb(std::span<const uint8_t> file);

// Everything that stands before the binary chunk's bytes, which the caller has padded to a multiple of 4.
// Zero bytes make no binary chunk. kUnsupported where the file would pass 4 GB, the most that GLB can say.
Expected<std::vector<uint8_t>> glb_head(std::string json, uint64_t binary_bytes);

}  // namespace psplit
