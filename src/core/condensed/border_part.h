// The border part of a condensed stream: values of the first attribute at places of its border walk, which are
// needed before the stream is decoded, and by other streams. Specification: "border parts"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/condensed/token_steps.h"
#include "src/core/stream_header.h"

namespace psplit::core {

// Starts the tokens of the part of a stream with models.has_borders: the first value, then differences.
// `symbols` has room for border_count values of border_components numbers each, `table_of` for a number for
// each value. After all steps of `tokens`, its section is behind the part.
PSPLIT_HD inline Fault start_border_part(const StreamHeader& header, View<uint8_t> table_of,
                                         View<uint32_t> symbols, TokenSequence& tokens) {
  const CondensedStream& stream = header.condensed;
  SectionReader section = stream.numbers(stream.numbers_end);
  if (const Fault fault = section.start_words(stream.first_section); fault != Fault::kNone) return fault;
  TableSet tables;
  for (uint32_t t = 0; t < 2; ++t) {
    tables.tables[t] = stream.models.border_tables[t];
    if (stream.border_count > t && tables.tables[t] == kNoTable) return Fault::kEntropy;
  }
  for (uint32_t i = 0; i < stream.border_count; ++i) table_of[i] = i > 0;
  tokens.start(section, stream.models, tables, stream.border_components, table_of.first(stream.border_count),
               symbols);
  return Fault::kNone;
}

}  // namespace psplit::core
