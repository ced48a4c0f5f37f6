// Prediction by several parallelograms (src/core/multi_parallelogram.h): the mean of the parallelograms around a value's vertex, without the
// ones that flags leave out. There are four lists of flags, one for each number of parallelograms.
export const multi_parallelogram = /* wgsl */ `
const kMostParallelograms = 4u;
struct Parallelograms { count: u32, across: array<u32, 4> }

// The far corner, if all values of the face across from a corner come before value k.
fn look_across(table: Table, corner: u32, k: u32, found: ptr<function, Parallelograms>) {
  let across = load(table.opposite, corner);
  if (across == kNone) { return; }
  for (var c = across & ~3u; c < (across & ~3u) + 3u; c++) { if (load(table.rank, load(table.vertex, c)) >= k) { return; } }
  (*found).across[(*found).count] = across;
  (*found).count += 1u;
}
// To the left from the corner at which the walk met the vertex, then to the right from there.
fn find_parallelograms(s: Stream, table: Table, start: u32, k: u32) -> Parallelograms {
  var found = Parallelograms(0u, array<u32, 4>());
  var corner = start;
  for (var n = 0u; n < 3u * s.face_count && found.count < kMostParallelograms; n++) {
    look_across(table, corner, k, &found);
    corner = swing_left(table.opposite, corner);
    if (corner == kNone || corner == start) { break; }
  }
  if (corner != kNone) { return found; }
  corner = start;
  for (var n = 0u; n < 3u * s.face_count && found.count < kMostParallelograms; n++) {
    corner = swing_right(table.opposite, corner);
    if (corner == kNone) { break; }
    look_across(table, corner, k, &found);
  }
  return found;
}

// Returns false if flags are missing.
fn predict_by_parallelograms(s: Stream, a: Attribute, table: Table, count: u32) -> bool {
  let head = head_of(a);
  let values = values_of(a);
  let corrections = corrections_of(a);
  let low = i32(load(head, kLow));
  let high = i32(load(head, kHigh));
  let width = a.value_components;
  var flags: array<Bits, 4>;
  var left: array<u32, 4>;
  for (var n = 0u; n < kMostParallelograms; n++) {
    left[n] = load(head, kCreases + 5u * n);
    flags[n] = stored_bits(head, kCreases + 5u * n + 1u);
  }
  var before = kNone;
  for (var k = 0u; k < count; k++) {
    let corner = load(table.corner, k);
    let out = width * load(table.vertex, corner);
    var found = find_parallelograms(s, table, corner, k);
    var kept = 0u;
    if (found.count > 0u) {
      let list = found.count - 1u;
      if (left[list] < found.count) { return false; }
      left[list] -= found.count;
      var bits = flags[list];
      for (var j = 0u; j < found.count; j++) {
        if (next_bit(&bits)) { continue; }
        found.across[kept] = found.across[j];
        kept += 1u;
      }
      flags[list] = bits;
    }
    for (var c = 0u; c < width; c++) {
      var predicted = 0;
      for (var j = 0u; j < kept; j++) {
        let across = found.across[j];
        predicted += i32(load(values, width * load(table.vertex, next(across)) + c)) +
          i32(load(values, width * load(table.vertex, previous(across)) + c)) - i32(load(values, width * load(table.vertex, across) + c));
      }
      if (kept > 0u) {
        predicted /= i32(kept);
      } else if (before != kNone) {
        predicted = i32(load(values, before + c));
      }
      store(values, out + c, u32(wrapped(predicted, signed_of_symbol(load(corrections, width * k + c)), low, high)));
    }
    before = out;
  }
  return true;
}
`;
