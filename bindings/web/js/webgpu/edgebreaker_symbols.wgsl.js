// What Edgebreaker reads (src/core/edgebreaker_symbols.h): a string of bits, or for a valence traversal a list of symbols for each valence.
export const clers = /* wgsl */ `
// C takes one bit, the others three.
const kC = 0u;
const kS = 1u;
const kL = 3u;
const kR = 5u;
const kE = 7u;
const kNoSymbol = 6u;

fn valences_of(s: Stream) -> View { return View(s.valences, s.vertex_limit + 3u); }
fn grow(s: Stream, vertex: u32, by: u32) { store(valences_of(s), vertex, load(valences_of(s), vertex) + by); }
// The symbol added the face with these vertices: a digit for each code of a symbol, the lowest digit for 0.
fn add_valences(s: Stream, symbol: u32, v0: u32, v1: u32, v2: u32) {
  grow(s, v0, (0x20101000u >> (4u * symbol)) & 3u);
  grow(s, v1, (0x20102011u >> (4u * symbol)) & 3u);
  grow(s, v2, (0x20201011u >> (4u * symbol)) & 3u);
}
// The class of a vertex's valence, from 0 to 5.
fn valence_class(s: Stream, vertex: u32) -> u32 { return clamp(load(valences_of(s), vertex), 2u, 7u) - 2u; }
`;
export const edgebreaker_symbols = /* wgsl */ `
struct SymbolString { bit: u32, left: array<u32, 6>, begin: array<u32, 6> }
fn start_symbols(s: Stream) -> SymbolString {
  var symbols = SymbolString(0u, array<u32, 6>(), array<u32, 6>());
  if (s.lists == kNone) { return symbols; }
  let valences = valences_of(s);
  for (var v = 0u; v < valences.y; v++) { store(valences, v, 0u); }
  var at = 0u;
  for (var k = 0u; k < 6u; k++) {
    symbols.begin[k] = at;
    symbols.left[k] = plan[plan[s.lists + k]];
    at += symbols.left[k];
  }
  return symbols;
}
fn next_standard(s: Stream, symbols: ptr<function, SymbolString>) -> u32 {
  let ahead = bits_at(s.symbols, (*symbols).bit, s.end);
  let is_long = ahead & 1u;
  (*symbols).bit += 1u + 2u * is_long;
  return select(0u, ahead & 7u, is_long != 0u);
}

// The next symbol of the list for the valence of the vertex that a C would close. Lists are read from their ends.
fn next_listed(s: Stream, symbols: ptr<function, SymbolString>, closing: u32) -> u32 {
  let k = valence_class(s, closing);
  if ((*symbols).left[k] == 0u) { return kNoSymbol; }
  (*symbols).left[k] -= 1u;
  let number = memory[s.listed + (*symbols).begin[k] + (*symbols).left[k]];
  if (number > 4u) { return kNoSymbol; }
  return select(2u * number - 1u, kC, number == 0u);
}

// One thread for each list of a stream.
@compute @workgroup_size(kStreamsPerGroup)
fn decode_lists(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let s = streams[window.first + id.x];
  if (s.lists == kNone) { return; }
  var out = s.listed;
  for (var k = 0u; k < id.y; k++) { out += plan[plan[s.lists + k]]; }
  let list = plan[s.lists + id.y];
  let precision_bits = plan[list + 1u];
  let at = plan[list + 2u];
  var size = plan[list + 3u];
  var state = plan[list + 4u];
  for (var n = 0u; n < plan[list]; n++) {
    for (var k = 0u; k < 4u && state < (4u << precision_bits) && size > 0u; k++) {
      size -= 1u;
      state = (state << 8u) | byte_at(at + size);
    }
    let number = state & ((1u << precision_bits) - 1u);
    // The last slot ends after all numbers.
    var slot = list + 5u;
    while (number >= plan[slot + 3u]) { slot += 2u; }
    memory[out + n] = plan[slot];
    state = (plan[slot + 3u] - plan[slot + 1u]) * (state >> precision_bits) + (number - plan[slot + 1u]);
  }
}
`;
