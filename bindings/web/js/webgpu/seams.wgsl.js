// Attribute seams (src/core/seams.h): each data cuts the mesh's corner table open along its seams, and vertices are split into points.
export const seams = /* wgsl */ `
// One thread for each attribute data of a stream: a bit for each edge between two faces, from its first face.
@compute @workgroup_size(kStreamsPerGroup)
fn cut(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  let d = id.y;
  if (!is_fine(i) || d >= s.data_count) { return; }
  let opposite = opposite_of(s);
  let vertex = vertex_of(s);
  let own = cut_opposite_of(s, d);
  let own_vertex = cut_vertex_of(s, d);
  let marks = on_seam_of(s, d);
  for (var c = 0u; c < own.y; c++) {
    store(own, c, load(opposite, c));
    store(own_vertex, c, load(vertex, c));
  }
  var bits = planned_bits(s.seams + 4u * d);
  var has_seams = 0u;
  for (var c = 0u; c < own.y; c++) {
    if ((c & 3u) == 3u) { continue; }
    let across = load(opposite, c);
    if (across == kNone || across >> 2u <= c >> 2u || !next_bit(&bits)) { continue; }
    has_seams = 1u;
    store(own, c, kNone);
    store(own, across, kNone);
    store(marks, load(vertex, next(c)), 1u);
    store(marks, load(vertex, previous(c)), 1u);
  }
  // The value at the first corner of a vertex has the vertex's number; all others have numbers after the vertices'.
  let vertex_count = state(i, kVertexCount);
  var count = vertex_count;
  for (var v = 0u; has_seams != 0u && v < vertex_count; v++) {
    if (load(marks, v) == 0u) { continue; }
    let leftmost = previous(load(border_of(s), v));
    var first = leftmost;
    for (var n = 0u; n < 3u * s.face_count; n++) {
      let left = swing_left(own, first);
      if (left == kNone || left == leftmost) { break; }
      first = left;
    }
    var number = v;
    var corner = first;
    for (var n = 0u; n < 3u * s.face_count; n++) {
      store(own_vertex, corner, number);
      let edge = previous(corner);
      let across = load(opposite, edge);
      if (across == kNone || previous(across) == first) { break; }
      if (load(own, edge) == kNone) {
        number = count;
        count += 1u;
      }
      corner = previous(across);
    }
  }
  store(data_words_of(s, d), kHasSeams, has_seams);
  store(data_words_of(s, d), kDataVertices, count);
  // Each value is at a point of its own.
  if (count > s.point_count) { fail(i); }
}

fn is_on_seam(s: Stream, vertex: u32) -> bool {
  for (var d = 0u; d < s.data_count; d++) { if (load(on_seam_of(s, d), vertex) != 0u) { return true; } }
  return false;
}
// Whether some attribute has other values at the two corners.
fn differs(s: Stream, a: u32, b: u32) -> bool {
  for (var d = 0u; d < s.data_count; d++) {
    let vertex = cut_vertex_of(s, d);
    if (load(data_words_of(s, d), kHasSeams) != 0u && load(vertex, a) != load(vertex, b)) { return true; }
  }
  return false;
}

// One thread numbers the points of a stream: by vertex, and clockwise around it.
@compute @workgroup_size(kStreamsPerGroup)
fn number_points(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || s.data_count == 0u) { return; }
  let opposite = opposite_of(s);
  let vertex = vertex_of(s);
  let point_at = point_at_of(s);
  let counts = point_counts_of(s);
  let point_of = corner_of_point_of(s);  // by number, until each point has its corner
  let vertex_count = state(i, kVertexCount);
  for (var c = 0u; c < point_at.y; c++) { store(point_at, c, load(vertex, c)); }
  var count = vertex_count;
  for (var v = 0u; v < vertex_count; v++) {
    store(counts, v, 1u);
    if (!is_on_seam(s, v)) { continue; }
    let before = count;
    let leftmost = previous(load(border_of(s), v));
    var first = leftmost;
    if (is_closed(s, v)) { first = first_point_corner(s, opposite, leftmost); }
    var number = v;
    var corner = first;
    for (var n = 0u; n < 3u * s.face_count; n++) {
      store(point_at, corner, number);
      let right = swing_right(opposite, corner);
      if (right == kNone || right == first) { break; }
      if (differs(s, corner, right)) {
        number = count;
        count += 1u;
      }
      corner = right;
    }
    store(counts, v, 1u + count - before);
  }
  if (count != s.point_count) {
    fail(i);
    return;
  }
  set_state(i, kPointCount, count);
  var point = 0u;
  var next_number = vertex_count;
  for (var v = 0u; v < vertex_count; v++) {
    store(point_of, v, point);
    point += 1u;
    for (var k = 1u; k < load(counts, v); k++) {
      store(point_of, next_number, point);
      next_number += 1u;
      point += 1u;
    }
  }
  for (var c = 0u; c < point_at.y; c++) {
    if ((c & 3u) != 3u) { store(point_at, c, load(point_of, load(point_at, c))); }
  }
  for (var c = 0u; c < point_at.y; c++) {
    if ((c & 3u) != 3u) { store(point_of, load(point_at, c), c); }
  }
}
// The corner at which the points of an interior vertex begin: the first one to the right of "leftmost" whose value differs from that of
// "leftmost" in some attribute; "leftmost" if no value changes around the vertex.
fn first_point_corner(s: Stream, opposite: View, leftmost: u32) -> u32 {
  for (var d = 0u; d < s.data_count; d++) {
    if (load(data_words_of(s, d), kHasSeams) == 0u) { continue; }
    let value = cut_vertex_of(s, d);
    var first = swing_right(opposite, leftmost);
    for (var n = 0u; n < 3u * s.face_count && first != leftmost && load(value, first) == load(value, leftmost); n++) {
      first = swing_right(opposite, first);
    }
    if (first != leftmost) { return first; }
  }
  return leftmost;
}
`;
