// Values that are predicted from positions (src/core/tex_coords.h): a triangle in the texture has the shape of the triangle in space. All
// numbers are integers, of 64 bits where they are products.
export const tex_coords = /* wgsl */ `
// The most that coordinates may be. Positions are -2^18 or more, as integers of 16 bits are. Then the CPU refuses no triangle: steps in space
// are at most 5/4 * 2^20, so a sum of three products of three of them fits 63 bits. All else is left to WebAssembly.
const kMostCoordinate = 1 << 20;

// Integer positions, at the corners of an attribute that is predicted from them.
struct Positions { own: Table, table: Table, values: View, has_seams: bool }
fn position_at(positions: Positions, corner: u32) -> vec3i {
  var met = corner;
  // If positions have seams as well, the corner is the one at which the attribute's walk met the value.
  if (positions.has_seams) { met = load(positions.own.corner, load(positions.own.rank, load(positions.own.vertex, corner))); }
  let at = 3u * load(positions.table.vertex, met);
  return vec3i(i32(load(positions.values, at)), i32(load(positions.values, at + 1u)), i32(load(positions.values, at + 2u)));
}

// One thread for each attribute, when positions are known.
@compute @workgroup_size(kStreamsPerGroup)
fn predict_from_positions(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || id.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + id.y];
  if (a.coding == kCodingRaw || a.position == 0u) { return; }
  let scheme = load(head_of(a), kScheme);
  if (scheme != kSchemeTexCoords && scheme != kSchemeGeometricNormal) { return; }
  let of_positions = attributes[s.attributes + a.position - 1u];
  let table = table_of(s, i, group_of(s, a.group));
  let position_table = table_of(s, i, group_of(s, of_positions.group));
  let positions = Positions(table, position_table, values_of(of_positions), position_table.vertex.x != s.vertex);
  for (var k = 0u; k < 3u * position_table.count; k++) {
    if (load(positions.values, k) + (1u << 18u) > (5u << 18u)) {
      fail(i);
      return;
    }
  }
  let count = load(head_of(a), kCount);
  if (scheme == kSchemeGeometricNormal) {
    predict_normals(s, a, table, positions, count);
  } else if (!predict_tex_coords(a, table, positions, count)) {
    fail(i);
  }
}

fn predict_tex_coords(a: Attribute, table: Table, positions: Positions, count: u32) -> bool {
  let head = head_of(a);
  let corrections = corrections_of(a);
  let values = values_of(a);
  let low = i32(load(head, kLow));
  let high = i32(load(head, kHigh));
  if (low < -kMostCoordinate || high > kMostCoordinate) { return false; }
  // The orientations of triangles, which are used from the last to the first: a bit each, where the table of symbols was.
  var left = load(head, kOrientations);
  if (left > 32u << a.bucket_bits) { return false; }
  let orientations = View(a.buckets, 1u << a.bucket_bits);
  var same = stored_bits(head, kFlips);
  var orientation = 1u;
  var word = 0u;
  for (var k = 0u; k < left; k++) {
    if (!next_bit(&same)) { orientation ^= 1u; }
    word = select(word, 0u, (k & 31u) == 0u) | (orientation << (k & 31u));
    store(orientations, k >> 5u, word);
  }
  var last = vec2i(0);
  for (var k = 0u; k < count; k++) {
    let tip = load(table.corner, k);
    let vn = load(table.vertex, next(tip));
    let vp = load(table.vertex, previous(tip));
    let has_next = load(table.rank, vn) < k;
    var predicted = last;
    if (has_next) { predicted = vec2i(i32(load(values, 2u * vn)), i32(load(values, 2u * vn + 1u))); }
    if (has_next && load(table.rank, vp) < k) {
      let n = predicted;
      let edge = vec2i(i32(load(values, 2u * vp)), i32(load(values, 2u * vp + 1u))) - n;
      let n_at = position_at(positions, next(tip));
      let pn = position_at(positions, previous(tip)) - n_at;
      let scale = dot_wide(pn, pn);
      if (any(edge != vec2i(0)) && !all(scale == kZero)) {
        if (left == 0u) { return false; }
        left -= 1u;
        let up = ((load(orientations, left >> 5u) >> (left & 31u)) & 1u) != 0u;
        predicted = tip_place(n, edge, pn, position_at(positions, tip) - n_at, scale, up);
      }
    }
    let s = wrapped(predicted.x, signed_of_symbol(load(corrections, 2u * k)), low, high);
    let t = wrapped(predicted.y, signed_of_symbol(load(corrections, 2u * k + 1u)), low, high);
    last = vec2i(s, t);
    // Broken corrections lead out of the range.
    if (any(clamp(last, vec2i(low), vec2i(high)) != last)) { return false; }
    let out = 2u * load(table.vertex, tip);
    store(values, out, u32(s));
    store(values, out + 1u, u32(t));
  }
  return true;
}

fn dot_wide(a: vec3i, b: vec3i) -> Wide { return plus(plus(product(a.x, b.x), product(a.y, b.y)), product(a.z, b.z)); }
// The place of the tip of a triangle on one side of the edge from n on. The foot is found along the edge; coordinates are scaled by the
// square of the edge in space until the last step.
fn tip_place(n: vec2i, edge: vec2i, pn: vec3i, cn: vec3i, scale: Wide, up: bool) -> vec2i {
  let along = dot_wide(pn, cn);
  var s = plus(times(wide(n.x), scale), times(along, wide(edge.x)));
  var t = plus(times(wide(n.y), scale), times(along, wide(edge.y)));
  let foot = vec3i(i32(quotient(times(along, wide(pn.x)), scale).x), i32(quotient(times(along, wide(pn.y)), scale).x),
    i32(quotient(times(along, wide(pn.z)), scale).x));
  let height = cn - foot;
  let length = wide_root(times(dot_wide(height, height), scale));
  let up_s = times(wide(edge.y), length);
  let up_t = times(wide(-edge.x), length);
  if (up) {
    s = plus(s, up_s);
    t = plus(t, up_t);
  } else {
    s = minus(s, up_s);
    t = minus(t, up_t);
  }
  return vec2i(i32(quotient(s, scale).x), i32(quotient(t, scale).x));
}
`;
