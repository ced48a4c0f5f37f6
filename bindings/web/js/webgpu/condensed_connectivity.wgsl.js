// The connectivity of a condensed stream (src/core/condensed/condensed_connectivity.h, seam_steps.h), after the part that it stores of its
// border (border_part.h). One thread for each stream.
export const condensed_connectivity = /* wgsl */ `
fn record_of(s: Stream, field: u32) -> u32 { return plan[s.symbols + field]; }

var<private> splits: u32;
// The context of the next symbol, or with valences the number of the last symbol.
struct SymbolString { last: u32, is_started: bool }
fn start_symbols(s: Stream) -> SymbolString {
  splits = 0u;
  if (s.lists == kNone) { return SymbolString(record_of(s, kContextCountField) - 1u, false); }
  let valences = valences_of(s);
  for (var v = 0u; v < valences.y; v++) { store(valences, v, 0u); }
  return SymbolString(4u, true);
}
fn symbol_in_context(context: u32) -> vec2u {
  let number = next_in_context(context);
  if (!is_used_context(context)) { return vec2u(number, kNoSymbol); }
  let symbol = select(2u * number - 1u, kC, number == 0u);
  splits += select(0u, 1u, symbol == kS);
  return vec2u(number, symbol);
}
// In a context of the last few symbols. The first symbol is E.
fn next_standard(s: Stream, symbols: ptr<function, SymbolString>) -> u32 {
  if (!(*symbols).is_started) {
    (*symbols).is_started = true;
    return kE;
  }
  let found = symbol_in_context(record_of(s, kContextsField) + 2u * (*symbols).last);
  (*symbols).last = (5u * (*symbols).last + found.x) % record_of(s, kContextCountField);
  return found.y;
}
// In a context of the last symbol and the valence of the vertex that a C would close.
fn next_listed(s: Stream, symbols: ptr<function, SymbolString>, closing: u32) -> u32 {
  let found = symbol_in_context(record_of(s, kContextsField) + 2u * (5u * valence_class(s, closing) + (*symbols).last));
  (*symbols).last = found.x;
  return found.y;
}

@compute @workgroup_size(kStreamsPerGroup)
fn decode_condensed(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i)) { return; }
  start_section(record_of(s, kFirstSectionField), s.end, record_of(s, kNumbersEndField));
  bits_taken = 0u;
  if (!read_own_values(s) || !add_all_faces(i, s) || bits_taken != record_of(s, kComponentsField) || splits != record_of(s, kSplitsField)) {
    fail(i);
    return;
  }
  read_seams(s);
  keep_section(record_of(s, kCoderField));
}

// Values at places of the border walk that no other stream owns: the first one, then differences.
fn read_own_values(s: Stream) -> bool {
  let width = record_of(s, kBorderWidthField);
  for (var k = 0u; k < record_of(s, kBorderCountField); k++) {
    let table = record_of(s, select(kFirstTableField, kOtherTableField, k > 0u));
    if (table == kNone) { return false; }
    for (var c = 0u; c < width; c++) { memory[record_of(s, kOwnValuesField) + width * k + c] = next_value(table); }
  }
  return true;
}

// A bit for each edge between two faces, from its first face, for each data that has seams.
fn read_seams(s: Stream) {
  let opposite = opposite_of(s);
  for (var d = 0u; d < s.data_count; d++) {
    let data = s.symbols + kDataOfField + kDataWordsField * d;
    if (plan[data + kHasBitsField] == 0u) { continue; }
    let bits = planned_bits(s.seams + 4u * d);
    var last = false;
    var count = 0u;
    for (var c = 0u; c < opposite.y; c++) {
      let across = load(opposite, c);
      if ((c & 3u) == 3u || across == kNone || across >> 2u <= c >> 2u) { continue; }
      last = next_decision(plan[data + select(kAfterNoneField, kAfterSeamField, last)]);
      store_decision(bits.at, min(count, 32u * bits.size - 1u), last);
      count += 1u;
    }
  }
}
`;
