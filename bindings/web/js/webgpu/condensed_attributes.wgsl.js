// The sections of the attributes of a condensed stream (src/core/condensed/condensed_attributes.h): tokens, then flags of their predictions.
// One thread for each attribute.
export const condensed_attributes = /* wgsl */ `
fn origin_of(a: Attribute, k: u32) -> u32 { return model_of(a, kOriginField + k); }

@compute @workgroup_size(kStreamsPerGroup)
fn decode_tokens(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || id.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + id.y];
  let count = table_of(s, i, group_of(s, a.group)).count;
  set_head(a, count);
  start_section(model_of(a, kBeginField), model_of(a, kEndField), 0u);
  if (id.y == 0u) { resume_section(record_of(s, kCoderField), model_of(a, kEndField)); }
  if (!read_tokens(s, a, count) || !section_ends()) { fail(i); }
}

// What predictions and results read of an attribute.
fn set_head(a: Attribute, count: u32) {
  let head = head_of(a);
  store(head, kCount, count);
  store(head, kScheme, model_of(a, kStoredSchemeField));
  store(head, kTransform, model_of(a, kStoredTransformField));
  store(head, kLow, model_of(a, kStoredLowField));
  store(head, kHigh, model_of(a, kStoredHighField));
  let bits = model_of(a, kStoredBitsField);
  store(head, kBits, bits);
  if (a.coding == kCodingQuantized) { store(head, kStep, divide(model_of(a, kRangeField), float_of(i32((1u << bits) - 1u)))); }
  if (a.coding == kCodingNormal) { store(head, kStep, divide(0x40000000u, float_of(i32((1u << bits) - 2u)))); }
}

// Returns false if a table is missing, or a correction is beyond the grid.
fn read_tokens(s: Stream, a: Attribute, count: u32) -> bool {
  const kFirst = 3u;  // values with a table of their own, unless parallelograms choose it
  let by_creation = model_of(a, kByCreationField) != 0u;
  let out = corrections_of(a);
  let width = a.value_components;
  var known = 0u;
  if (by_creation) { known = known_count(order_of(s, a)); }
  let predictors = View(model_of(a, kPredictorsField), model_of(a, kPredictorWordsField) * s.point_count);
  let has_grid = !by_creation && model_of(a, kHasGridField) != 0u;
  for (var k = 0u; k < count - known; k++) {
    var table = select(0u, 1u, k >= kFirst);
    if (by_creation) { table = load(predictors, model_of(a, kPredictorWordsField) * k); }
    table = model_of(a, kTablesField + table);
    if (table == kNone) { return false; }
    for (var c = 0u; c < width; c++) {
      var symbol = next_value(table);
      if (has_grid) {
        if (symbol >= model_of(a, kStoredHighField)) { return false; }
        symbol = u32(signed_of_symbol(symbol));
      }
      store(out, width * k + c, symbol);
    }
  }
  if (!by_creation) { read_flags(a, count); }
  return true;
}

// Decodes flags to bits in memory, one list after the other, and says in the head where they are.
fn read_flags(a: Attribute, count: u32) {
  let head = head_of(a);
  let scheme = model_of(a, kStoredSchemeField);
  var at = model_of(a, kFlagsField);
  if (scheme == kSchemeParallelograms) {
    for (var list = 0u; list < 4u; list++) {
      let flags = model_of(a, kFlagCountsField + list);
      store(head, kCreases + 5u * list, flags);
      at = take_flags(head, kCreases + 5u * list + 1u, at, flags, model_of(a, kCreasesField + list));
    }
  } else if (scheme == kSchemeTexCoords) {
    let flags = model_of(a, kFlagCountsField);
    store(head, kOrientations, flags);
    _ = take_flags(head, kFlips, at, flags, model_of(a, kOrientationField));
  } else if (scheme == kSchemeGeometricNormal) {
    _ = take_flags(head, kFlips, at, count, model_of(a, kFlipField));
  }
}
fn take_flags(head: View, to: u32, at: u32, count: u32, probability: u32) -> u32 {
  let size = max((count + 31u) / 32u, 1u);
  for (var k = 0u; k < count; k++) { store_decision(at, k, next_decision(probability)); }
  store(head, to, kBitsInMemory);
  store(head, to + 1u, at);
  store(head, to + 2u, size);
  store(head, to + 3u, 0u);
  return at + size;
}
`;
