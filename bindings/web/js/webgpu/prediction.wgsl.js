// Corrections to values (src/core/prediction.h and the files that it names). One thread for each attribute of a stream: each value is
// predicted from values before it.
export const prediction = /* wgsl */ `
// The number that a symbol stands for: 0, -1, 1, -2, 2 ...
fn signed_of_symbol(symbol: u32) -> i32 { return i32((symbol >> 1u) ^ (0u - (symbol & 1u))); }

// Clamps a predicted value to a range, adds a correction, and wraps the sum back into the range.
fn wrapped(predicted: i32, correction: i32, low: i32, high: i32) -> i32 {
  let value = clamp(predicted, low, high) + correction;
  let modulus = i32(u32(high) - u32(low) + 1u);
  return select(select(value, value + modulus, value < low), value - modulus, value > high);
}

@compute @workgroup_size(kStreamsPerGroup)
fn predict(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || id.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + id.y];
  if (a.coding == kCodingRaw) { return; }
  let head = head_of(a);
  let table = table_of(s, i, group_of(s, a.group));
  let scheme = load(head, kScheme);
  let values = values_of(a);
  let corrections = corrections_of(a);
  let count = load(head, kCount);
  let width = a.value_components;
  if (scheme == kSchemeNone) {
    for (var k = 0u; k < count; k++) {
      let out = width * load(table.vertex, load(table.corner, k));
      for (var c = 0u; c < width; c++) { store(values, out + c, u32(signed_of_symbol(load(corrections, width * k + c)))); }
    }
  } else if (a.coding == kCodingNormal) {
    if (scheme == kSchemeDifference) { correct_normals(a, table, count); }
  } else if (scheme == kSchemeParallelograms) {
    if (!predict_by_parallelograms(s, a, table, count)) { fail(i); }
  } else if (scheme == kSchemeDifference || scheme == kSchemeParallelogram) {
    let low = i32(load(head, kLow));
    let high = i32(load(head, kHigh));
    var before = kNone;
    for (var k = 0u; k < count; k++) {
      let corner = load(table.corner, k);
      let out = width * load(table.vertex, corner);
      // predicted = a + b - far, or the value before
      var of_a = before;
      var of_b = kNone;
      var of_far = kNone;
      let across = load(table.opposite, corner);
      if (scheme == kSchemeParallelogram && across != kNone) {
        let va = load(table.vertex, next(across));
        let vb = load(table.vertex, previous(across));
        let vfar = load(table.vertex, across);
        if (load(table.rank, va) < k && load(table.rank, vb) < k && load(table.rank, vfar) < k) {
          of_a = width * va;
          of_b = width * vb;
          of_far = width * vfar;
        }
      }
      for (var c = 0u; c < width; c++) {
        var predicted = 0;
        if (of_a != kNone) { predicted = i32(load(values, of_a + c)); }
        if (of_b != kNone) { predicted += i32(load(values, of_b + c)) - i32(load(values, of_far + c)); }
        let value = wrapped(predicted, signed_of_symbol(load(corrections, width * k + c)), low, high);
        store(values, out + c, u32(value));
      }
      before = out;
    }
  }
}
`;
