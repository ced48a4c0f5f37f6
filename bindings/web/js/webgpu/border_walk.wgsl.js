// The border of a patch in walking order (src/core/border_walk.h), and the numbers of a stream's points in the mesh (stitch.h).
export const border_walk = /* wgsl */ `
fn successor_of(s: Stream) -> View { return View(s.scratch, s.point_count); }
fn walk_of(s: Stream) -> View { return View(s.scratch + s.point_count, s.point_count); }

var<workgroup> is_broken: atomic<u32>;
var<workgroup> edges: atomic<u32>;

// Takes the edge across from a corner, which has no face on its other side, or a face with other points.
fn link_edge(s: Stream, opposite: View, point_at: View, corner: u32) {
  let start = next(corner);
  let a = load(point_at, start);
  let b = load(point_at, previous(corner));
  // The edge is inside the mesh if some face around a has it in the other direction.
  var at = start;
  for (var n = 0u; n < 3u * s.face_count; n++) {
    if (load(point_at, previous(at)) == b) { return; }
    at = swing_left(opposite, at);
    if (at == kNone || at == start || load(point_at, at) != a) { break; }
  }
  if (load(successor_of(s), a) != kNone) { atomicStore(&is_broken, 1u); }
  store(successor_of(s), a, b);
  atomicAdd(&edges, 1u);
}

// All lanes of a group link the edges of a stream. Each lane links the edges of its own vertices, so that no two lanes write one point.
@compute @workgroup_size(kLanes)
fn link_border(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let i = window.first + group.x;
  let s = streams[i];
  let is_due = is_fine(i) && s.has_walk != 0u;
  let successor = successor_of(s);
  for (var point = lane; is_due && point < s.point_count; point += kLanes) { store(successor, point, kNone); }
  storageBarrier();
  workgroupBarrier();
  let opposite = opposite_of(s);
  let point_at = point_at_of(s);
  let vertex_count = state(i, kVertexCount);
  for (var v = lane; is_due && v < vertex_count; v += kLanes) {
    let edge = load(border_of(s), v);
    let closed = is_closed(s, v);
    if (s.data_count == 0u) {
      if (!closed) { link_edge(s, opposite, point_at, edge); }
      continue;
    }
    if (closed && !is_on_seam(s, v)) { continue; }
    let first = previous(edge);
    var at = first;
    for (var n = 0u; n < 3u * s.face_count; n++) {
      let corner = previous(at);
      let across = load(opposite, corner);
      let is_joined = across != kNone && load(point_at, previous(across)) == load(point_at, at) &&
        load(point_at, next(across)) == load(point_at, next(at));
      if (!is_joined) { link_edge(s, opposite, point_at, corner); }
      at = swing_right(opposite, at);
      if (at == kNone || at == first) { break; }
    }
  }
  workgroupBarrier();
  // The number of edges of the walk; 0 if two edges leave one point, which makes the border invalid.
  if (lane == 0u && is_due) { set_state(i, kWalkLength, select(atomicLoad(&edges), 0u, atomicLoad(&is_broken) != 0u)); }
}

// One thread walks the border of a stream, and numbers its points.
@compute @workgroup_size(kStreamsPerGroup)
fn number(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i)) { return; }
  if (state(i, kPointCount) != s.point_count) {
    fail(i);
    return;
  }
  let walk = walk_of(s);
  var length = 0u;
  if (s.has_walk != 0u) { length = follow_border(s, state(i, kWalkLength)); }
  if (!number_points_of(s, i, walk, length)) {
    fail(i);
    return;
  }
  let numbers = numbers_of(s);
  for (var k = 0u; k < length; k++) {
    let number = load(numbers, load(walk, k));
    walks[s.walk + k] = select(kNone, number, number < s.mesh_points);
  }
  set_state(i, kWalkLength, length);
}

// Returns the length of the walk. It is 0 if the edges do not form loops.
fn follow_border(s: Stream, edge_count: u32) -> u32 {
  let successor = successor_of(s);
  let walk = walk_of(s);
  var length = 0u;
  for (var start = 0u; start < s.point_count && length < edge_count; start++) {
    if (load(successor, start) == kNone) { continue; }
    var at = start;
    loop {
      let following = load(successor, at);
      if (following == kNone || length == edge_count) { return 0u; }
      store(walk, length, at);
      length += 1u;
      store(successor, at, kNone);
      at = following;
      if (at == start) { break; }
    }
  }
  return length;
}

// A point's number becomes that in the mesh if stream i owns it, and the count of the mesh's points plus n if it is the n-th reference.
// Resolves repeats. Returns false if the stitch map is broken.
fn number_points_of(s: Stream, i: u32, walk: View, length: u32) -> bool {
  let numbers = numbers_of(s);
  let references = references_of(s);
  for (var point = 0u; point < s.point_count; point++) { store(numbers, point, kNone); }
  if (s.reference_count > 0u && !read_stitch_map(s, i, walk, length)) { return false; }
  var owned = s.first_point;
  for (var point = 0u; point < s.point_count; point++) {
    if (load(numbers, point) == kNone) {
      store(numbers, point, owned);
      owned += 1u;
    }
  }
  for (var r = 0u; r < s.reference_count; r++) {
    if (load(references, 2u * r) != kIsRepeat) { continue; }
    let number = load(numbers, load(references, 2u * r + 1u));
    if (number >= s.mesh_points) { return false; }
    store(references, 2u * r + 1u, number);
  }
  return true;
}
`;
