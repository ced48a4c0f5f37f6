// A section of a condensed stream (src/core/condensed/section.h, token_steps.h, context_symbols.h): 16-bit words for an entropy coder from
// its front, plain bits from its back. Of those that it lacks, words are the last ones, and bits are others: section_ends() is false then.
export const section = /* wgsl */ `
struct Section { end: u32, at: u32, taken: u32, state: u32 }
var<private> section: Section;  // of the invocation
const kSlots = 4096u;
const kCoderBase = 65536u;

// Bits are read after the first "taken" ones.
fn start_section(begin: u32, end: u32, taken: u32) { section = Section(end, begin + 4u, taken, bits_at(begin, 0u, kNone)); }
// An invocation goes on where another one has been.
fn keep_section(to: u32) {
  memory[to] = section.at;
  memory[to + 1u] = section.taken;
  memory[to + 2u] = section.state;
}
fn resume_section(at: u32, end: u32) { section = Section(end, memory[at], memory[at + 1u], memory[at + 2u]); }

// At most 30 bits, the first one lowest. Each byte is read from its lowest bit, from the last byte on.
fn section_bits(count: u32) -> u32 {
  let last = section.end - 1u - (section.taken >> 3u);
  let shift = section.taken & 7u;
  let word = bits_at(last - 3u, 0u, kNone);
  var value = ((word << 24u) | ((word << 8u) & 0xff0000u) | ((word >> 8u) & 0xff00u) | (word >> 24u)) >> shift;
  if (shift > 0u) { value |= byte_at(last - 4u) << (32u - shift); }
  section.taken += count;
  return value & ((1u << count) - 1u);
}
// The step of the coder after a symbol of so many slots, in which "offset" is the place of the current one.
fn leave_slot(frequency: u32, offset: u32) {
  var state = frequency * (section.state >> 12u) + offset;
  if (state < kCoderBase) {
    let at = min(section.at, section.end - 2u);
    state = (state << 16u) | byte_at(at) | (byte_at(at + 1u) << 8u);
    section.at += 2u;
  }
  section.state = state;
}
// A decision with this probability of 1.
fn next_decision(probability: u32) -> bool {
  let slot = section.state % kSlots;
  let one = slot < probability;
  leave_slot(select(kSlots - probability, probability, one), slot - select(probability, 0u, one));
  return one;
}
// Whether words and bits fill the section, as an encoder left it.
fn section_ends() -> bool {
  let size = (section.taken + 7u) >> 3u;
  return section.state == kCoderBase && section.at <= section.end && section.end - section.at == size &&
    section_bits(8u * size - section.taken) == 0u;
}

// The next symbol of a value, as a token of the table at a place in the plan: a small symbol, or its two highest bits. The last slot of a
// table ends after all numbers.
fn next_value(table: u32) -> u32 {
  const kBuckets = 64u;
  const kDirect = 64u;
  let number = section.state % kSlots;
  var slot = table + kBuckets + plan[table + number / 64u];
  var here = plan[slot];
  var after = plan[slot + 1u];
  while (number >= after >> 8u) {
    slot += 1u;
    here = after;
    after = plan[slot + 1u];
  }
  leave_slot((after >> 8u) - (here >> 8u), number - (here >> 8u));
  let token = here & 0xffu;
  if (token < kDirect) { return token; }
  let count = (token - kDirect) / 2u + 5u;
  return ((2u + (token & 1u)) << count) + section_bits(count);
}

// The number of the next symbol of C, S, L, R and E in a context, two words of the plan.
fn next_in_context(context: u32) -> u32 {
  let number = section.state % kSlots;
  let a = plan[context];
  let b = plan[context + 1u];
  let firsts = array<u32, 4>(a & 0x1fffu, (a >> 16u) & 0x1fffu, b & 0x1fffu, (b >> 16u) & 0x1fffu);
  var symbol = 0u;
  var first = 0u;
  var end = kSlots;
  for (var k = 0u; k < 4u; k++) {
    let is_later = number >= firsts[k];
    symbol += select(0u, 1u, is_later);
    first = select(first, firsts[k], is_later);
    end = select(min(end, firsts[k]), end, is_later);
  }
  leave_slot(end - first, number - first);
  return symbol;
}
fn is_used_context(context: u32) -> bool { return plan[context] >> 31u != 0u; }

// Bits that are decoded: constant, or in words of the plan or of memory.
struct Bits { kind: u32, at: u32, size: u32, taken: u32 }
const kBitsInPlan = 1u;
const kBitsInMemory = 2u;
fn planned_bits(at: u32) -> Bits { return Bits(plan[at], plan[at + 1u], plan[at + 2u], 0u); }
var<private> bits_taken: u32;
fn next_bit(bits: ptr<function, Bits>) -> bool {
  let k = (*bits).taken;
  (*bits).taken += 1u;
  bits_taken += 1u;
  let word = (*bits).at + min(k >> 5u, (*bits).size - 1u);
  var value = (*bits).at;
  if ((*bits).kind == kBitsInPlan) { value = plan[word] >> (k & 31u); }
  if ((*bits).kind == kBitsInMemory) { value = memory[word] >> (k & 31u); }
  return (value & 1u) != 0u;
}
// Decodes bits to words of memory.
fn store_decision(at: u32, k: u32, bit: bool) {
  let word = at + (k >> 5u);
  let before = select(memory[word], 0u, (k & 31u) == 0u);
  memory[word] = before | (select(0u, 1u, bit) << (k & 31u));
}
`;
