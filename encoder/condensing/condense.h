// Codes the Draco streams of one primitive under models that they share. Specification: "condensed streams"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "psplit/parallel.h"
#include "src/container/patch_container.h"

namespace psplit {

// The streams of a container. One that is not condensed is stored as it is.
struct CondensedStreams {
  std::vector<uint8_t> head;                // empty if no stream is condensed
  std::vector<StreamEntry> entries;         // the container's streams, condensed or not
  std::vector<std::vector<uint8_t>> bytes;  // by stream; empty if it is not condensed
};

// `draco` has the streams of one primitive. Only its entries, streams and stitch map are used. Each condensed
// stream is expanded again: it is stored instead if that does not give the same bytes, or if it does not get
// smaller. `smallest` chooses the smallest coding; otherwise a coding that is slower to decode must save bytes
// worth it.
//
// The result depends neither on the number of threads nor, with IEEE 754 arithmetic, on the machine. One
// exception: whether a stream gives the same bytes depends, very rarely, on the C library's log2
// (encoder/fields/entropy_encoder.cpp).
//
// Until it returns, it takes about 40 bytes for each decoded point of positions, and 20 more for each further
// attribute: far less than a partition (measured: Dragon, patches of 440 and 4,800 faces).
CondensedStreams condense(const PatchContainer& draco, bool smallest, const ThreadPool& pool);

// A container of condensed streams.
struct CondensedContainer {
  std::vector<uint8_t> bytes;
  std::vector<StreamEntry> entries;
  uint32_t head_bytes = 0;
};

// The container with the streams that condense() returns and the same stitch map. Empty unless it takes fewer
// than `bytes_without` bytes, the size of the container without condensing.
std::optional<CondensedContainer> condense_container(const PatchContainer& draco, uint64_t bytes_without,
                                                     bool smallest, const ThreadPool& pool);

}  // namespace psplit
