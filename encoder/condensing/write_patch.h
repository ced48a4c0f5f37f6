// Writes a condensed patch: the fields that are not in its skeleton, under the models. Specification: "a
// condensed patch".
#pragma once

#include "encoder/condensing/border_symbols.h"
#include "encoder/condensing/section_writer.h"
#include "encoder/condensing/shared_models.h"

namespace psplit {

// The models' tables, ready for coding.
struct CodingTables {
  explicit CodingTables(const Models& models);
  std::vector<std::vector<SymbolSlots>> symbols;             // by context
  using TokenSlots = std::vector<std::vector<SymbolSlots>>;  // by table
  std::vector<std::vector<TokenSlots>> tokens;               // by attribute and set
  TokenSlots borders;
};

// A patch whose values and symbols are coded. Of its fields it needs everything except the attributes' symbols
// and raw bytes.
struct CodedPatch {
  DracoFields fields;
  uint32_t point_count = 0;
  std::vector<uint16_t> contexts;       // of all symbols except the first
  std::vector<CodedValues> attributes;  // in the order of the stream
  BorderPart border;
};

std::vector<uint8_t> write_patch(const CodedPatch& patch, const Models& models, const CodingTables& tables);

}  // namespace psplit
