// Writes a condensed patch: the fields that are not in its skeleton, under the models of the head.
// Specification: "a condensed patch".
#pragma once

#include <cstdint>
#include <vector>

#include "encoder/condensing/border_symbols.h"
#include "encoder/condensing/coded_patch.h"
#include "src/container/condensed_head.h"

namespace psplit {

// A patch whose values and symbols are coded. Of its fields it needs everything except the attributes' symbols
// and raw bytes.
struct CodedPatch {
  DracoFields fields;
  uint32_t point_count = 0;
  std::vector<uint16_t> contexts;       // of all symbols except the first
  std::vector<CodedValues> attributes;  // in the order of the stream
  BorderPart border;
};

// `head` is what a decoder reads from write_head(models).
std::vector<uint8_t> write_patch(const CodedPatch& patch, const CondensedHead& head);

}  // namespace psplit
