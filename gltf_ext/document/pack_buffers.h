// All bytes of a document, gathered into the few buffers that its file has.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/document/packed_buffer.h"
#include "gltf_ext/json/json.h"

namespace psplit {

struct PackedDocument {
  // As a file has it, but for its "buffers": those are the document's until list_buffers is called.
  Json json;
  PackedBuffer bytes;  // buffer 0
  // Buffer 1: data that a loader of compressed primitives never reads. Empty if it is not stored apart.
  PackedBuffer fallback;
  // The JSON of buffer 0, and of the placeholders, which come last: meshoptimizer's extension supplies their
  // data.
  Json first = Json::object(), without_bytes = Json::array();
  std::vector<std::string> warnings;
  Json second = Json::object();  // the JSON of buffer 1
};

// The parts of the result's buffers point into `document`. If `fallback_apart` is true, the uncompressed data
// of compressed primitives, and that of coarse ones, goes into a buffer of its own.
PackedDocument pack_buffers(const Document& document, bool fallback_apart);

// Writes json["buffers"], after all bytes were added. If there are no bytes, there are no buffers.
void list_buffers(PackedDocument& packed);

}  // namespace psplit
