// The GLB container: a header, a JSON chunk, at most one binary chunk.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psplit/base.h"

namespace psplit {

struct GlbChunks {
  std::span<const uint8_t> json;
  std::optional<std::span<const uint8_t>> binary;
};

bool is_glb(std::span<const uint8_t> file);

// Whether bytes begin as a GLB does, or as the JSON of a .gltf.
bool begins_as_gltf(std::span<const uint8_t> file);

// The spans point into `file`. Unknown chunks and bytes past the stated length are skipped.
Expected<GlbChunks> parse_glb(std::span<const uint8_t> file);

// kUnsupported if a file of that many bytes would exceed 4 GB, the limit of GLB. `is_least`: the file takes
// that many bytes or more.
Status check_glb_bytes(uint64_t bytes, bool is_least = false);

// Everything before the bytes of the binary chunk, whose length must be a multiple of 4. A length of 0 makes no
// binary chunk. kUnsupported if the file would exceed 4 GB, the limit of GLB.
Expected<std::vector<uint8_t>> glb_head(std::string json, uint64_t binary_bytes);

}  // namespace psplit
