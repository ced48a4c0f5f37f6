// Sequences of unsigned integers: Draco's two symbol codings.
//
//   raw     every value is one rANS symbol
//   tagged  for each group of components one rANS symbol says how many bits each of its values takes; the bits
//           follow in plain
#pragma once

#include "src/core/rans.h"

namespace psplit::core {

// Decodes values in groups of `components`; visit(i, value) for each in turn. The table lives in the arena and
// is given back. `group_count` may be 0, for which nothing at all is stored.
template <typename Visit>
PSPLIT_HD Fault decode_symbols(ByteReader& reader, uint32_t group_count, uint32_t components, Arena& arena,
                               Visit visit) {
  if (group_count == 0) return Fault::kNone;
  constexpr uint8_t kTagged = 0, kRaw = 1;
  constexpr uint32_t kTagBits = 5, kMostSymbolBits = 18;
  const size_t mark = arena.mark();
  const uint8_t coding = reader.u8();
  if (coding != kTagged && coding != kRaw) return reader.truncated() ? Fault::kTruncated : Fault::kMethod;
  const uint32_t symbol_bits = coding == kTagged ? kTagBits : reader.u8();
  if (symbol_bits == 0 || symbol_bits > kMostSymbolBits) return Fault::kEntropy;
  const uint32_t wanted = 3 * symbol_bits / 2;
  RansTable table;
  RansSymbols symbols;
  Fault fault = table.read(reader, static_cast<int>(wanted < 12 ? 12 : wanted > 20 ? 20 : wanted), arena);
  if (fault == Fault::kNone) fault = symbols.start(reader, table);
  if (fault != Fault::kNone) return fault;

  if (coding == kRaw) {
    symbols.decode(table, group_count * components, visit);
  } else {
    BitReader bits(reader.head(), reader.remaining());
    uint32_t i = 0;
    symbols.decode(table, group_count, [&](uint32_t, uint32_t bit_count) {
      if (bit_count > 32) fault = Fault::kEntropy;
      if (fault != Fault::kNone) return;
      for (uint32_t k = 0; k < components; ++k) visit(i++, bits.read(static_cast<int>(bit_count)));
    });
    if (fault != Fault::kNone) return fault;
    // Bits past the end read as 0, and are not there to be skipped.
    if (!reader.skip(bits.bytes_taken())) return Fault::kTruncated;
  }
  arena.release(mark);
  return Fault::kNone;
}

// 0, -1, 1, -2, 2 ... as 0, 1, 2, 3, 4 ...
PSPLIT_HD constexpr int32_t signed_of_symbol(uint32_t symbol) {
  const auto magnitude = static_cast<int32_t>(symbol >> 1);
  return (symbol & 1) != 0 ? -magnitude - 1 : magnitude;
}

}  // namespace psplit::core
