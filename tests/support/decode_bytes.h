// Opens bytes and decodes them once, for tests that decode nothing else of them.
#pragma once

#include "src/container/decode_backend.h"
#include "src/container/patch_container.h"

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

}  // namespace psplit
