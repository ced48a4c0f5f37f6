// Data of many accessors that get few views, and accessors that are then equal.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "gltf_ext/document/document.h"

namespace psplit {

// Blocks of bytes, one after the other. Blocks that are equal are stored once.
class JoinedBlocks {
 public:
  struct Place {
    size_t begin = 0;
    bool is_new = false;
  };
  // A new block begins at a multiple of `alignment`.
  Place add(std::span<const uint8_t> block, size_t alignment);
  void pad(size_t alignment) { bytes_.resize((bytes_.size() + alignment - 1) / alignment * alignment); }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::unordered_map<std::string, size_t> begins_;
  std::vector<uint8_t> bytes_;
};

// Joins accessors that are equal: all references then name the first. Returns the others, which no longer have
// data. Unknown data must not name any of these accessors.
std::vector<int64_t> share_accessors(Document& document, std::span<const int64_t> accessors);

}  // namespace psplit
