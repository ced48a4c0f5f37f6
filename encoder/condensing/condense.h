// Codes the Draco streams of one primitive under models that they share. Specification: "condensed streams"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/parallel.h"

namespace psplit {

// What the directory says about a stream.
struct DecodedCounts {
  uint32_t face_count = 0;
  uint32_t point_count = 0;  // as decoded
  // Its part of the stitch map. Values at borders are stored once if the streams have such parts.
  uint32_t reference_count = 0;
  std::span<const uint8_t> stitch{};
};

// The streams of a container. One that is not condensed is stored as it is.
struct CondensedStreams {
  std::vector<uint8_t> head;  // empty if no stream is condensed
  // By stream.
  std::vector<std::vector<uint8_t>> bytes;
  std::vector<uint8_t> is_condensed;  // 0 or 1
  std::vector<uint8_t> skeleton;      // of the head; 0 if the stream is not condensed
};

// `draco_streams` are the streams of one primitive, the residue among them, and `counts` has an item for each.
// Each condensed stream is expanded again: it is stored instead if that does not give the same bytes, or if it
// does not get smaller. `smallest` chooses the smallest coding; otherwise a coding that is slower to decode
// must save bytes worth it.
//
// The result depends neither on the number of threads nor, with IEEE 754 arithmetic, on the machine. One
// exception: whether a stream gives the same bytes depends, very rarely, on the C library's log2
// (src/condensed/entropy_encoder.cpp).
//
// Until it returns, it takes about 40 bytes for each decoded point of positions, and 20 more for each further
// attribute: far less than a partition (measured: Dragon, patches of 440 and 4,800 faces).
CondensedStreams condense(std::span<const std::vector<uint8_t>> draco_streams,
                          std::span<const DecodedCounts> counts, bool smallest, const ThreadPool& pool);

}  // namespace psplit
