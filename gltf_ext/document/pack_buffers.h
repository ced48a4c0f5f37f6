// All bytes of a document in as few buffers as its file has.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/packed_buffer.h"

namespace psplit {

struct PackedDocument {
  Json json;           // its "buffers" are the document's until list_buffers
  PackedBuffer bytes;  // buffer 0
  // Buffer 1: what a loader that decodes compressed primitives never reads. Empty where it is not kept apart.
  PackedBuffer fallback;
  // What the JSON says of buffer 0, and of buffers that have no bytes (meshoptimizer's extension stands in for
  // them), which come last.
  Json first = Json::object(), without_bytes = Json::array();
  std::vector<std::string> warnings;
};

// The parts of the buffers point into `document`. `fallback_apart` puts the uncompressed data of compressed
// primitives into a buffer of its own.
PackedDocument pack_buffers(const Document& document, bool fallback_apart);

// Writes json["buffers"] once all bytes are in. Where there are no bytes, there are no buffers.
void list_buffers(PackedDocument& packed);

}  // namespace psplit
