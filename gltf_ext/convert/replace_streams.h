// Other bytes in the places of Draco streams and containers.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>

#include "gltf_ext/document/document.h"

namespace psplit {

// The new bytes of each buffer view, which must not be empty.
using StreamReplacements = std::map<int64_t, std::span<const uint8_t>>;

// Replaces the bytes of the buffer views in place, as if the new bytes had been written at first. Later bytes
// of a buffer move: streams begin at multiples of 4 bytes, and everything else keeps its alignment. So
// replacing there and back gives the same buffer, and smaller bytes never make it larger. Bytes that another
// view shares stay, and their replacement is appended.
void replace_streams(Document& document, const StreamReplacements& replacements);

// The first place from `at` on where a stream may begin.
constexpr uint64_t aligned_for_stream(uint64_t at) {
  constexpr uint64_t kAlignment = 4;
  return (at + kAlignment - 1) / kAlignment * kAlignment;
}

// A lower bound of the bytes that a file loses by smaller replacements in views of replaceable_views: the
// buffers of a file begin at multiples of 8.
uint64_t bytes_saved(Document& document, const StreamReplacements& replacements);

// The buffer views whose bytes no other view shares.
std::set<int64_t> replaceable_views(const Document& document);

}  // namespace psplit
