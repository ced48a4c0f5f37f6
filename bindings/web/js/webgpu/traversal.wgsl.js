// The order of values (src/core/traversal.h): a walk over the faces that meets every vertex of a group's table. One thread for each group
// of a stream.
export const traversal = /* wgsl */ `
struct Walk {
  vertex: View, corner: View, rank: View, seen: View,
  start: u32,  // the first face that may not be seen
  count: u32,  // vertices that were met
}
const kUnseenOpen = kNone;
const kUnseenClosed = kNone - 1u;

fn face_seen(walk: ptr<function, Walk>, corner: u32) -> bool {
  return ((load((*walk).seen, corner >> 7u) >> ((corner >> 2u) & 31u)) & 1u) != 0u;
}
fn face_done(walk: ptr<function, Walk>, corner: u32) -> bool { return corner == kNone || face_seen(walk, corner); }
// Returns whether the vertex is new and closed.
fn see_vertex(walk: ptr<function, Walk>, corner: u32) -> bool {
  let vertex = load((*walk).vertex, corner);
  let before = load((*walk).rank, vertex);
  if (before >= kUnseenClosed) {
    store((*walk).corner, (*walk).count, corner);
    store((*walk).rank, vertex, (*walk).count);
    (*walk).count += 1u;
  }
  return before == kUnseenClosed;
}

@compute @workgroup_size(kStreamsPerGroup)
fn traverse(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || id.y >= s.group_count) { return; }
  let group = group_of(s, id.y);
  if (group.walk == kNone) { return; }  // another group has the same walk
  let table = table_of(s, i, group);
  let has_cut = table.vertex.x != s.vertex;
  let seen = View(group.walk, (s.face_count >> 5u) + 1u);
  var walk = Walk(table.vertex, table.corner, table.rank, seen, 0u, 0u);
  for (var k = 0u; k < seen.y; k++) { store(seen, k, 0u); }
  let vertex_count = state(i, kVertexCount);
  for (var v = 0u; v < table.count; v++) {
    var closed = v < vertex_count && is_closed(s, v);
    if (closed && has_cut) { closed = load(on_seam_of(s, group.data), v) == 0u; }
    store(walk.rank, v, select(kUnseenOpen, kUnseenClosed, closed));
  }
  if (group.by_degree) { walk_by_degree(s, table, &walk); } else { walk_depth_first(s, table, &walk); }
  if (walk.count != table.count) { fail(i); }
}

// The first corner of a component that was not walked.
fn begin_component(s: Stream, walk: ptr<function, Walk>) -> u32 {
  while ((*walk).start + 1u < s.face_count && face_seen(walk, 4u * (*walk).start)) { (*walk).start += 1u; }
  let corner = 4u * (*walk).start;
  _ = see_vertex(walk, next(corner));
  _ = see_vertex(walk, previous(corner));
  return corner;
}
fn see_face(walk: ptr<function, Walk>, corner: u32) {
  let seen = load((*walk).seen, corner >> 7u);
  store((*walk).seen, corner >> 7u, seen | (1u << ((corner >> 2u) & 31u)));
}

// Turns right as long as there is an unvisited face, and keeps the faces on the left for later.
fn walk_depth_first(s: Stream, table: Table, walk: ptr<function, Walk>) {
  let waiting = View((*walk).seen.x + (*walk).seen.y, s.face_count + 1u);
  var waiting_count = 0u;
  var corner = kNone;
  for (var n = 0u; n < s.face_count; n++) {
    // Dead ends go back to the last face that waits, or begin another component.
    while (corner == kNone && waiting_count > 0u) {
      waiting_count -= 1u;
      let back = load(waiting, waiting_count);
      if (!face_seen(walk, back)) { corner = back; }
    }
    if (corner == kNone) { corner = begin_component(s, walk); }
    let right = load(table.opposite, next(corner));
    let left = load(table.opposite, previous(corner));
    see_face(walk, corner);
    let right_done = face_done(walk, right);
    let left_done = face_done(walk, left);
    // Around a new vertex inside the mesh, the walk to the right comes back on the left by itself.
    let inside = see_vertex(walk, corner);
    if (!inside && !right_done && !left_done) {
      store(waiting, waiting_count, left);
      waiting_count += 1u;
    }
    corner = select(right, select(left, kNone, left_done), right_done);
  }
}

// Goes first to faces whose vertices are all seen, then to faces whose new vertex can be predicted from two visited faces, then to all
// others. A stack of corners waits for each of these three: the first grows upwards from the start of an array, the second downwards from
// its end, and the third has an array of its own.
fn walk_by_degree(s: Stream, table: Table, walk: ptr<function, Walk>) {
  let room = 2u * s.face_count + 1u;
  let waiting = View((*walk).seen.x + (*walk).seen.y, 2u * room);
  let degrees = View(waiting.x + waiting.y, s.point_count);
  for (var v = 0u; v < degrees.y; v++) { store(degrees, v, 0u); }
  var bottom = array<u32, 3>(0u, room - 1u, room);
  var top = bottom;
  var step = array<u32, 3>(1u, kNone, 1u);
  var best = 0u;  // no corner waits with a lower number
  var corner = kNone;
  for (var n = 0u; n < s.face_count; n++) {
    while (corner == kNone && best < 3u) {
      if (top[best] == bottom[best]) {
        best += 1u;
        continue;
      }
      top[best] -= step[best];
      let back = load(waiting, top[best]);
      if (!face_seen(walk, back)) { corner = back; }
    }
    if (corner == kNone) {
      corner = begin_component(s, walk);
      best = 0u;
    }
    let right = load(table.opposite, next(corner));
    let left = load(table.opposite, previous(corner));
    see_face(walk, corner);
    _ = see_vertex(walk, corner);
    let right_done = face_done(walk, right);
    corner = kNone;
    for (var side = 0u; side < 2u; side++) {
      let beside = select(left, right, side == 1u);
      if (face_done(walk, beside)) { continue; }
      let vertex = load(table.vertex, beside);
      var priority = 0u;
      if (load(table.rank, vertex) >= kUnseenClosed) {
        let degree = load(degrees, vertex) + 1u;
        store(degrees, vertex, min(degree, 2u));
        priority = select(2u, 1u, degree > 1u);
      }
      if (priority <= best && (side == 1u || right_done)) {
        corner = beside;
        break;
      }
      store(waiting, top[priority], beside);
      top[priority] += step[priority];
      best = min(best, priority);
    }
  }
}
`;
