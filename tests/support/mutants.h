// Changes of bytes, as damage and attacks make them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace psplit {

// Flips a bit at a place, overwrites the byte, inserts one or removes it.
inline void edit(std::vector<uint8_t>& bytes, size_t at, std::mt19937& random) {
  const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  switch (random() % 4) {
    case 0: *place ^= static_cast<uint8_t>(1u << random() % 8); break;
    case 1: *place = static_cast<uint8_t>(random()); break;
    case 2: bytes.insert(place, static_cast<uint8_t>(random())); break;
    default:
      if (bytes.size() > 1) bytes.erase(place);
  }
}

// Calls visit(part) with the first 0, 1, ... bytes, but not with all. Each part is a block of exactly its size,
// so that the address sanitizer sees an access one byte after it.
template <typename Visit>
void for_each_truncation(std::span<const uint8_t> bytes, Visit visit) {
  for (size_t length = 0; length < bytes.size(); ++length) {
    const auto part = bytes.first(length);
    visit(std::vector<uint8_t>(part.begin(), part.end()));
  }
}

}  // namespace psplit
