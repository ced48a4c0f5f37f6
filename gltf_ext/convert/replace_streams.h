// Other bytes in the places of Draco streams and containers.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>

#include "gltf_ext/document/document.h"

namespace psplit {

// By buffer view. The bytes must not be empty.
using StreamReplacements = std::map<int64_t, std::span<const uint8_t>>;

// Gives the bytes the places of what the buffer views held, as if they had been written at first. What follows
// them in a buffer moves: streams begin at multiples of 4 bytes, everything else keeps its alignment. So
// replacing there and back gives the same buffer, and one with smaller bytes is not larger. Bytes that another
// view shares stay, and their replacement is appended.
void replace_streams(Document& document, const StreamReplacements& replacements);

// The first place from `at` on where a stream may begin.
constexpr uint64_t aligned_for_stream(uint64_t at) {
  constexpr uint64_t kAlignment = 4;
  return (at + kAlignment - 1) / kAlignment * kAlignment;
}

// The bytes that a file surely loses by replacements that are smaller than what they replace, in views of
// replaceable_views: the buffers of a file begin at multiples of 8.
uint64_t bytes_saved(Document& document, const StreamReplacements& replacements);

// The buffer views whose bytes no other view shares.
std::set<int64_t> replaceable_views(const Document& document);

}  // namespace psplit
