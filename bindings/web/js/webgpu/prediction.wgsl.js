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

// A place on an octahedral grid (src/core/octahedral.h), and how corrections change it.
struct OctahedralGrid { most: i32, center: i32, canonicalized: bool }
fn grid_of(head: View) -> OctahedralGrid {
  let most = i32(load(head, kHigh));
  return OctahedralGrid(most, (most - 1) / 2, load(head, kTransform) == kTransformCanonicalized);
}
fn negated(x: i32, is_so: bool) -> i32 { return select(x, -x, is_so); }
// Reflects a place, relative to the center, at the nearest edge of the diamond.
fn mirrored(grid: OctahedralGrid, at: vec2i) -> vec2i {
  let right = at.x > 0 || (at.x == 0 && at.y >= 0);
  let up = at.y > 0 || (at.y == 0 && at.x >= 0);
  let corner = vec2i(negated(grid.center, !right), negated(grid.center, !up));
  let same = right == up;
  return vec2i(negated(2 * at.y - corner.y, same) + corner.x, negated(2 * at.x - corner.x, same) + corner.y) / 2;
}
// The number of quarter turns that bring a place to the bottom left quadrant.
fn quarter_turns(at: vec2i) -> u32 {
  let below = at.y < 0;
  return select(select(select(0u, 1u, below && at.x >= 0), 3u, at.y > 0), select(2u, 1u, below), at.x > 0);
}
// After 0, 1, 2 and 3 quarter turns: (s, t), (t, -s), (-s, -t), (-t, s).
fn turned(at: vec2i, turns: u32) -> vec2i {
  let swapped = select(at, at.yx, (turns & 1u) != 0u);
  return vec2i(negated(swapped.x, turns > 1u), negated(swapped.y, turns == 1u || turns == 2u));
}
// Brings sums back into the square, whose opposite sides meet.
fn folded(grid: OctahedralGrid, x: i32) -> i32 { return select(select(x, x + grid.most, x < -grid.center), x - grid.most, x > grid.center); }
fn corrected(grid: OctahedralGrid, predicted: vec2i, correction: vec2i) -> vec2i {
  let place = predicted - grid.center;
  let outside = u32(abs(place.x)) + u32(abs(place.y)) > u32(grid.center);
  let p = select(place, mirrored(grid, place), outside);
  let turns = select(0u, quarter_turns(p), grid.canonicalized);
  let sum = turned(p, turns) + correction;
  let value = turned(vec2i(folded(grid, sum.x), folded(grid, sum.y)), (4u - turns) & 3u);
  return select(value, mirrored(grid, value), outside) + grid.center;
}

// Each normal is predicted to be the same as the one before.
fn correct_normals(a: Attribute, table: Table, count: u32) {
  let grid = grid_of(head_of(a));
  let corrections = corrections_of(a);
  let values = values_of(a);
  var last = vec2i(0, 0);
  for (var k = 0u; k < count; k++) {
    last = corrected(grid, last, vec2i(i32(load(corrections, 2u * k)), i32(load(corrections, 2u * k + 1u))));
    let out = 2u * load(table.vertex, load(table.corner, k));
    store(values, out, u32(last.x));
    store(values, out + 1u, u32(last.y));
  }
}
`;
