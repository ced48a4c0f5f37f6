// Normals (src/core/normals.h): predicted to be the same as the one before, or from the faces around a vertex.
export const normals = /* wgsl */ `
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

// The sum of the normals of all faces at a corner's vertex: each is as long as its face is large.
struct WideVector { x: Wide, y: Wide, z: Wide }
fn normal_at(s: Stream, table: Table, positions: Positions, start: u32) -> WideVector {
  let center = position_at(positions, start);
  var sum = WideVector(kZero, kZero, kZero);
  var corner = start;
  var leftwards = true;
  for (var n = 0u; n < 3u * s.face_count && corner != kNone; n++) {
    let a = position_at(positions, next(corner)) - center;
    let b = position_at(positions, previous(corner)) - center;
    sum.x = plus(sum.x, minus(product(a.y, b.z), product(a.z, b.y)));
    sum.y = plus(sum.y, minus(product(a.z, b.x), product(a.x, b.z)));
    sum.z = plus(sum.z, minus(product(a.x, b.y), product(a.y, b.x)));
    if (leftwards) { corner = swing_left(table.opposite, corner); } else { corner = swing_right(table.opposite, corner); }
    if (corner == start) { break; }
    if (corner == kNone && leftwards) {
      leftwards = false;
      corner = swing_right(table.opposite, start);
    }
  }
  return sum;
}

fn predict_normals(s: Stream, a: Attribute, table: Table, positions: Positions, count: u32) {
  let head = head_of(a);
  let grid = grid_of(head);
  let corrections = corrections_of(a);
  let values = values_of(a);
  var flips = stored_bits(head, kFlips);
  for (var k = 0u; k < count; k++) {
    let corner = load(table.corner, k);
    var v = normal_at(s, table, positions, corner);
    // Not longer than about 2^29, so that products with the center fit.
    var length = plus(plus(magnitude(v.x), magnitude(v.y)), magnitude(v.z));
    if (is_above(length, Wide(1u << 29u, 0u))) {
      let by = Wide((length.x >> 29u) | (length.y << 3u), length.y >> 29u);
      v = WideVector(quotient(v.x, by), quotient(v.y, by), quotient(v.z, by));
      length = plus(plus(magnitude(v.x), magnitude(v.y)), magnitude(v.z));
    }
    var at = vec3i(grid.center, 0, 0);
    if (!all(length == kZero)) {
      let center = wide(grid.center);
      at.x = i32(quotient(times(v.x, center), length).x);
      at.y = i32(quotient(times(v.y, center), length).x);
      at.z = negated(grid.center - abs(at.x) - abs(at.y), is_below_zero(v.z));
    }
    let predicted = place_of(grid, select(at, -at, next_bit(&flips)));
    let value = corrected(grid, predicted, vec2i(i32(load(corrections, 2u * k)), i32(load(corrections, 2u * k + 1u))));
    let out = 2u * load(table.vertex, corner);
    store(values, out, u32(value.x));
    store(values, out + 1u, u32(value.y));
  }
}
`;
