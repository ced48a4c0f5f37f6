// Entropy decoding (src/core/rans.h): bits that share one probability, and symbols of a table. Both read their bytes from the last
// to the first.
export const rans = /* wgsl */ `
// A run of bits, whose block the plan has found.
struct Bits { probability: u32, at: u32, size: u32, state: u32 }
fn planned_bits(at: u32) -> Bits { return Bits(plan[at], plan[at + 1u], plan[at + 2u], plan[at + 3u]); }
fn next_bit(bits: ptr<function, Bits>) -> bool {
  const kBase = 4096u;
  if ((*bits).state < kBase && (*bits).size > 0u) {
    (*bits).size -= 1u;
    (*bits).state = ((*bits).state << 8u) | byte_at((*bits).at + (*bits).size);
  }
  let probability = (*bits).probability;
  let one = ((*bits).state >> 8u) * probability;
  let rest = (*bits).state & 0xffu;
  let bit = rest < probability;
  (*bits).state = select((*bits).state - one - probability, one + rest, bit);
  return bit;
}

// A table of symbols: slots in the order of their first numbers, each a symbol and its first number, and one slot more with the sum
// of all. The top bits of a number say at which slot to begin a search.
struct Symbols { slots: View, buckets: View, bucket_shift: u32, precision_bits: u32, at: u32, size: u32, state: u32 }
fn next_symbol(symbols: ptr<function, Symbols>) -> u32 {
  let precision_bits = (*symbols).precision_bits;
  let base = 4u << precision_bits;
  var state = (*symbols).state;
  var size = (*symbols).size;
  // A state below its base lacks at most three bytes.
  for (var k = 0u; k < 4u && state < base && size > 0u; k++) {
    size -= 1u;
    state = (state << 8u) | byte_at((*symbols).at + size);
  }
  let number = state & ((1u << precision_bits) - 1u);
  var slot = load((*symbols).buckets, number >> (*symbols).bucket_shift);
  let slots = (*symbols).slots;
  var first = load(slots, 2u * slot + 1u);
  var end = load(slots, 2u * slot + 3u);
  // The last slot ends after all numbers.
  while (number >= end && 2u * slot + 5u < slots.y) {
    slot += 1u;
    first = end;
    end = load(slots, 2u * slot + 3u);
  }
  (*symbols).state = (end - first) * (state >> precision_bits) + (number - first);
  (*symbols).size = size;
  return load(slots, 2u * slot);
}
`;
