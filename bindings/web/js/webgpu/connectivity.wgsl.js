// Edgebreaker (src/core/edgebreaker.h, which draws its symbols): from a string of C, L, E, R and S to a corner table. One thread takes
// the symbols of a stream.
export const connectivity = /* wgsl */ `
// What begins empty, by all lanes of a group for a stream.
@compute @workgroup_size(kLanes)
fn begin(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let s = streams[window.first + group.x];
  for (var c = lane; c < 4u * s.face_count; c += kLanes) { memory[s.opposite + c] = kNone; }
  for (var d = 0u; d < s.data_count; d++) {
    let marks = on_seam_of(s, d);
    for (var v = lane; v < marks.y; v += kLanes) { store(marks, v, 0u); }
  }
}

fn link(opposite: View, a: u32, b: u32) {
  store(opposite, a, b);
  store(opposite, b, a);
}

@compute @workgroup_size(kStreamsPerGroup)
fn decode(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  if (is_fine(i) && !add_all_faces(i, streams[i])) { fail(i); }
}

// Returns false if the symbols are no mesh.
fn add_all_faces(i: u32, s: Stream) -> bool {
  let opposite = opposite_of(s);
  let vertex = vertex_of(s);
  let border = border_of(s);
  let beyond = beyond_of(s);
  // The stack of waiting edges, the edges that events set aside, and the merged vertices.
  let stack = View(s.scratch, s.symbol_count + 1u);
  let merged = View(stack.x + stack.y, s.symbol_count + 1u);
  let aside = View(merged.x + merged.y, s.symbol_count + 1u);
  if (s.event_count > 0u) { for (var k = 0u; k < s.symbol_count; k++) { store(aside, k, kNone); } }
  var stack_size = 0u;
  var merged_count = 0u;
  var events_left = s.event_count;
  var active_edge = 0u;
  var here = 0u;   // the vertex that the active edge leaves
  var there = 0u;  // and the one that it runs to
  var vertex_count = 0u;
  var degenerate = false;
  let has_lists = s.lists != kNone;
  var symbols = start_symbols(s);
  for (var n = 0u; n < s.symbol_count; n++) {
    var symbol = kE;
    if (!has_lists) {
      symbol = next_standard(s, &symbols);
    } else if (n > 0u) {
      symbol = next_listed(s, &symbols, there);
    }
    let c0 = 4u * n;
    let c1 = c0 + 1u;
    let c2 = c0 + 2u;
    let x = vertex_count;
    var v0 = x;
    var v1 = x + 1u;
    var v2 = x + 2u;
    if (n == 0u && symbol != kE) { return false; }
    if (symbol == kC) {
      let b = load(border, there);
      v0 = there;
      v1 = load(beyond, there);
      v2 = here;
      link(opposite, active_edge, c1);
      link(opposite, b, c2);
    } else if (symbol == kL) {
      v0 = there;
      v1 = x;
      v2 = here;
      store(border, x, c2);
      store(beyond, x, there);
      link(opposite, active_edge, c1);
      vertex_count += 1u;
    } else if (symbol == kR) {
      v0 = here;
      v1 = there;
      v2 = x;
      store(border, here, c1);
      store(beyond, here, x);
      link(opposite, active_edge, c2);
      vertex_count += 1u;
    } else if (symbol == kS) {
      if (degenerate) { return false; }
      var b = kNone;
      if (s.event_count > 0u) { b = load(aside, n); }
      if (b == kNone) {
        if (stack_size == 0u) { return false; }
        stack_size -= 1u;
        b = load(stack, stack_size);
      }
      let p = load(vertex, previous(b));
      let gone = there;
      v0 = p;
      v1 = load(vertex, next(b));
      v2 = here;
      if (load(opposite, b) != kNone || p == gone) { return false; }
      if (has_lists) { grow(s, p, load(valences_of(s), gone)); }
      // Vertex "gone" becomes part of p. The corners of "gone" are a chain to the border.
      var at = next(active_edge);
      var across = load(opposite, previous(active_edge));
      for (var k = 0u; k < 3u * s.face_count; k++) {
        store(vertex, at, p);
        if (across == kNone) { break; }
        at = next(across);
        across = load(opposite, next(at));
      }
      store(border, p, load(border, gone));
      store(beyond, p, load(beyond, gone));
      store(border, gone, kNone);
      store(merged, merged_count, gone);
      merged_count += 1u;
      link(opposite, active_edge, c1);
      link(opposite, b, c2);
    } else if (symbol != kE) {
      return false;
    } else {
      if (n > 0u) {
        store(stack, stack_size, active_edge);
        stack_size += 1u;
      }
      vertex_count += 3u;
      store(border, v0, c1);
      store(beyond, v0, v2);
      store(border, v1, c2);
      store(beyond, v1, v0);
    }
    if (vertex_count > s.vertex_limit) { return false; }
    store(vertex, c0, v0);
    store(vertex, c1, v1);
    store(vertex, c2, v2);
    if (has_lists) { add_valences(s, symbol, v0, v1, v2); }
    degenerate = degenerate || v1 == v2;
    store(border, v2, c0);
    store(beyond, v2, v1);
    active_edge = c0;
    here = v2;
    there = v1;
    // Only symbols that bring a vertex have events.
    if (events_left > 0u && plan[s.events + 3u * (events_left - 1u)] == n) {
      if (symbol == kC || symbol == kS) { return false; }
      while (events_left > 0u && plan[s.events + 3u * (events_left - 1u)] == n) {
        events_left -= 1u;
        let split = plan[s.events + 3u * events_left + 1u];
        if (split > n) { store(aside, split, select(c2, c1, plan[s.events + 3u * events_left + 2u] != 0u)); }
      }
    }
  }
  if (events_left > 0u || degenerate) { return false; }
  store(stack, stack_size, active_edge);
  stack_size += 1u;

  // The faces at which the components begin.
  var starts = planned_bits(s.start_faces);
  var face_count = s.symbol_count;
  while (stack_size > 0u) {
    stack_size -= 1u;
    let a = load(stack, stack_size);
    if (!next_bit(&starts)) { continue; }
    if (face_count >= s.face_count || load(opposite, a) != kNone) { return false; }
    let p = load(vertex, previous(a));
    let n = load(vertex, next(a));
    let b = load(border, n);
    let x = load(vertex, next(b));
    let c = load(border, x);
    if (b == a || load(vertex, next(c)) != p) { return false; }
    let c0 = 4u * face_count;
    face_count += 1u;
    link(opposite, a, c0);
    link(opposite, b, c0 + 1u);
    link(opposite, c, c0 + 2u);
    store(vertex, c0, x);
    store(vertex, c0 + 1u, p);
    store(vertex, c0 + 2u, n);
  }
  if (face_count != s.face_count) { return false; }
  let count = select(fill_holes(s, merged, merged_count, vertex_count), move_up(s, merged_count, vertex_count), s.data_count > 0u);
  set_state(i, kVertexCount, count);
  set_state(i, kPointCount, count);
  // Points are as many as vertices, or more.
  return count <= s.point_count;
}

// Both give merged vertices' numbers to others, and return the number of vertices. The order counts if there are attribute data.
fn move_up(s: Stream, merged_count: u32, vertex_count: u32) -> u32 {
  if (s.data_count == 0u || merged_count == 0u) { return vertex_count; }
  let border = border_of(s);
  let beyond = beyond_of(s);
  let vertex = vertex_of(s);
  var count = 0u;
  for (var v = 0u; v < vertex_count; v++) {
    let corner = load(border, v);
    if (corner != kNone) { store(border, count, corner); }
    store(beyond, v, count);
    count += select(0u, 1u, corner != kNone);
  }
  for (var c = 0u; c < 4u * s.face_count; c++) {
    if ((c & 3u) != 3u) { store(vertex, c, load(beyond, load(vertex, c))); }
  }
  return count;
}
fn fill_holes(s: Stream, merged: View, merged_count: u32, vertex_count: u32) -> u32 {
  if (s.data_count > 0u) { return vertex_count; }
  let opposite = opposite_of(s);
  let border = border_of(s);
  var count = vertex_count;
  for (var k = 0u; k < merged_count; k++) {
    let hole = load(merged, k);
    var corner = load(border, count - 1u);
    while (corner == kNone && count > 1u) {
      count -= 1u;
      corner = load(border, count - 1u);
    }
    let last = count - 1u;
    if (last < hole) { continue; }
    let start = previous(corner);
    var at = start;
    for (var n = 0u; n < 3u * s.face_count; n++) {
      store(vertex_of(s), at, hole);
      at = swing_right(opposite, at);
      if (at == kNone || at == start) { break; }
    }
    store(border, hole, corner);
    store(border, last, kNone);
    count -= 1u;
  }
  return count;
}
`;
