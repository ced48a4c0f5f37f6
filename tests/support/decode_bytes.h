// Opens the bytes of containers: to decode them once, or to change their parts.
#pragma once

#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "tests/support/expect.h"

namespace psplit {

inline Expected<Mesh> decode_container(const DecodeBackend& backend, std::span<const uint8_t> bytes,
                                       std::span<const AttributeRequest> requests, const ThreadPool& pool) {
  const Expected<PatchContainer> container = open_container(bytes);
  if (!container) return container.status();
  return backend.decode(*container, requests, pool);
}

inline Expected<Mesh> decode_stream(const DecodeBackend& backend, std::span<const uint8_t> bytes,
                                    std::span<const AttributeRequest> requests) {
  return backend.decode(open_stream(bytes), requests, ThreadPool(1));
}

// A container in parts that own their bytes: to change them, and to write it again.
struct ContainerParts {
  std::vector<StreamEntry> entries;
  std::vector<std::vector<uint8_t>> stitch, streams;
  bool has_residue = false;
  std::vector<uint8_t> head;

  ContainerParts() = default;
  explicit ContainerParts(const PatchContainer& container)
      : entries(container.entries), has_residue(container.has_residue) {
    for (const auto& part : container.stitch) stitch.emplace_back(part.begin(), part.end());
    for (const auto& part : container.streams) streams.emplace_back(part.begin(), part.end());
    const auto bytes = container.bytes.first(container.header_bytes).last(container.head_bytes);
    head.assign(bytes.begin(), bytes.end());
  }
  // The rows get the sizes of their parts.
  std::vector<uint8_t> write() const {
    std::vector<StreamEntry> rows = entries;
    for (size_t i = 0; i < rows.size(); ++i) {
      rows[i].stitch_bytes = static_cast<uint32_t>(stitch[i].size());
      rows[i].stream_bytes = static_cast<uint32_t>(streams[i].size());
    }
    return write_container(rows, has_residue, stitch, streams, head);
  }
};

}  // namespace psplit
