// The border part of a condensed stream: values of the first attribute at places of its border walk, which are
// needed before the stream is decoded, and by other streams. Specification: "border parts"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/condensed/token_steps.h"
#include "src/core/integer_vectors.h"
#include "src/core/stream_header.h"
#include "src/core/symbols.h"

namespace psplit::core {

// Decodes the part of a stream with models.has_borders. `values` has room for border_count values of
// border_components numbers each. `behind` becomes the coder behind the part.
PSPLIT_HD inline Fault decode_border_part(const StreamHeader& header, View<int32_t> values,
                                          SectionReader& behind) {
  const CondensedStream& stream = header.condensed;
  SectionReader section = stream.numbers(stream.numbers_end);
  if (const Fault fault = section.start_words(stream.first_section); fault != Fault::kNone) return fault;
  const uint32_t components = stream.border_components;
  for (uint32_t i = 0; i < stream.border_count; ++i) {
    const uint16_t number = stream.models.border_tables[i > 0 ? 1 : 0];
    if (number == kNoTable) return Fault::kEntropy;
    const TokenEntry* const table = &stream.models.token_tables[size_t{number} * kSlots];
    for (uint32_t k = 0; k < components; ++k) {
      const size_t at = size_t{i} * components + k;
      const TokenBits bits = bits_of_token(section.next_token(table));
      const uint32_t symbol = bits.base + section.read(static_cast<int>(bits.bit_count));
      const auto difference = static_cast<int32_t>(signed_of_symbol(symbol));
      values[at] = wrapping_add(i > 0 ? values[at - components] : 0, difference);
    }
  }
  behind = section;
  return Fault::kNone;
}

}  // namespace psplit::core
