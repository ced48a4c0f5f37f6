// The order of values (src/core/traversal.h): a walk over the faces, depth first, that meets every vertex of a group's table. One
// thread for each group of a stream.
export const traversal = /* wgsl */ `
struct Walk {
  vertex: View, corner: View, rank: View, seen: View,
  unseen: u32,  // faces
  count: u32,   // vertices that were met
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
  let waiting = View(group.walk, s.face_count + 1u);
  var walk = Walk(table.vertex, table.corner, table.rank, View(group.walk + waiting.y, (s.face_count >> 5u) + 1u), s.face_count, 0u);
  for (var k = 0u; k < walk.seen.y; k++) { store(walk.seen, k, 0u); }
  let vertex_count = state(i, kVertexCount);
  for (var v = 0u; v < table.count; v++) {
    var closed = v < vertex_count && is_closed(s, v);
    if (closed && has_cut) { closed = load(on_seam_of(s, group.data), v) == 0u; }
    store(walk.rank, v, select(kUnseenOpen, kUnseenClosed, closed));
  }
  var waiting_count = 0u;
  var start = 0u;
  var corner = kNone;
  for (var n = 0u; n < s.face_count; n++) {
    // Dead ends go back to the last face that waits, or begin another component.
    while (corner == kNone && waiting_count > 0u) {
      waiting_count -= 1u;
      let back = load(waiting, waiting_count);
      if (!face_seen(&walk, back)) { corner = back; }
    }
    if (corner == kNone) {
      while (start + 1u < s.face_count && face_seen(&walk, 4u * start)) { start += 1u; }
      corner = 4u * start;
      _ = see_vertex(&walk, next(corner));
      _ = see_vertex(&walk, previous(corner));
    }
    let right = load(table.opposite, next(corner));
    let left = load(table.opposite, previous(corner));
    let seen = load(walk.seen, corner >> 7u);
    store(walk.seen, corner >> 7u, seen | (1u << ((corner >> 2u) & 31u)));
    let right_done = face_done(&walk, right);
    let left_done = face_done(&walk, left);
    // Around a new vertex inside the mesh, the walk to the right comes back on the left by itself.
    let inside = see_vertex(&walk, corner);
    if (!inside && !right_done && !left_done) {
      store(waiting, waiting_count, left);
      waiting_count += 1u;
    }
    corner = select(right, select(left, kNone, left_done), right_done);
  }
  if (walk.count != table.count) { fail(i); }
}
`;
