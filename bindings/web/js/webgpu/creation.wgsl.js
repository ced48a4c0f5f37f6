// Values in order of creation (src/core/condensed/creation.h): vertices are as they occur at the corners of faces, and each value is predicted
// from parallelograms of values before it.
export const creation = /* wgsl */ `
fn model_of(a: Attribute, field: u32) -> u32 { return plan[a.slots + field]; }

// The number of vertices whose values are known, the corner at which each vertex came, and the place of each vertex.
struct Order { at: u32, corner: View, rank: View }
fn order_of(s: Stream, a: Attribute) -> Order {
  let at = model_of(a, kOrderField);
  return Order(at, View(at + 1u, s.point_count + 1u), View(at + 2u + s.point_count, s.point_count));
}
fn known_count(order: Order) -> u32 { return memory[order.at]; }

// One thread for each attribute that has an order of its own.
@compute @workgroup_size(kStreamsPerGroup)
fn find_orders(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || id.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + id.y];
  if (model_of(a, kIsOrderOwnerField) == 0u) { return; }
  let table = table_of(s, i, group_of(s, a.group));
  let order = order_of(s, a);
  for (var v = 0u; v < table.count; v++) { store(order.rank, v, kNone); }
  var count = 0u;
  if (model_of(a, kHasKnownField) != 0u) { count = take_known(s, i, a, table, order); }
  memory[order.at] = count;
  let backward = model_of(a, kBackwardField) != 0u;
  for (var n = 0u; n < s.face_count; n++) {
    let face = 4u * select(n, s.face_count - 1u - n, backward);
    for (var k = 0u; k < 3u; k++) {
      let corner = face + select(k, (k + 1u) % 3u, backward);
      let vertex = load(table.vertex, corner);
      if (load(order.rank, vertex) != kNone) { continue; }
      store(order.corner, count, corner);
      store(order.rank, vertex, count);
      count += 1u;
    }
  }
  if (count != table.count) { fail(i); }
}
// Vertices on the border come first. Returns their number.
fn take_known(s: Stream, i: u32, a: Attribute, table: Table, order: Order) -> u32 {
  let walk = walk_of(s);
  let values = values_of(a);
  let width = a.value_components;
  var count = 0u;
  for (var place = 0u; place < state(i, kWalkLength); place++) {
    var vertex = load(walk, place);
    if (s.data_count > 0u) { vertex = load(table.vertex, load(corner_of_point_of(s), vertex)); }
    if (load(order.rank, vertex) != kNone) { continue; }
    store(order.corner, count, 0u);
    store(order.rank, vertex, count);
    count += 1u;
    for (var c = 0u; c < width; c++) { store(values, width * vertex + c, walks[known_at(s, place) + 1u + c]); }
  }
  return count;
}

// All lanes of a group for each attribute: the number of parallelograms that predict a value, and the vertices of one or two: edge and far
// vertex. A value without a parallelogram is predicted from one that is three times the same value; kNone stands for zeros.
struct Parallelogram { a: u32, b: u32, far: u32, counts: bool }
fn parallelogram(table: Table, order: Order, k: u32, a: u32, b: u32, across: u32) -> Parallelogram {
  var found = Parallelogram(a, b, 0u, false);
  if (across == kNone) { return found; }
  found.far = load(table.vertex, across);
  found.counts = load(order.rank, a) < k && load(order.rank, b) < k && load(order.rank, found.far) < k;
  return found;
}
@compute @workgroup_size(kLanes)
fn find_predictors(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let i = window.first + group.x;
  let s = streams[i];
  if (!is_fine(i) || group.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + group.y];
  if (model_of(a, kByCreationField) == 0u) { return; }
  let table = table_of(s, i, group_of(s, a.group));
  let order = order_of(s, a);
  let known = known_count(order);
  let words = model_of(a, kPredictorWordsField);
  let out = View(model_of(a, kPredictorsField), words * s.point_count);
  for (var k = known + lane; k < table.count; k += kLanes) {
    let corner = load(order.corner, k);
    let of_next = load(table.vertex, next(corner));
    let of_previous = load(table.vertex, previous(corner));
    let at = words * (k - known);
    var count = 0u;
    var found = parallelogram(table, order, k, of_next, of_previous, load(table.opposite, corner));
    if (found.counts) { count = store_parallelogram(out, at, 0u, found); }
    if (model_of(a, kTwoField) != 0u) {
      // At the corners of the vertex on the left and on the right.
      let left = load(table.opposite, next(corner));
      if (left != kNone) {
        found = parallelogram(table, order, k, of_previous, load(table.vertex, left), load(table.opposite, next(left)));
        if (found.counts) { count = store_parallelogram(out, at, count, found); }
      }
      let right = load(table.opposite, previous(corner));
      if (right != kNone && count < 2u) {
        found = parallelogram(table, order, k, load(table.vertex, right), of_next, load(table.opposite, previous(right)));
        if (found.counts) { count = store_parallelogram(out, at, count, found); }
      }
    }
    store(out, at, count);
    if (count == 0u) {
      let has_next = load(order.rank, of_next) < k;
      let has_previous = load(order.rank, of_previous) < k;
      var only = kNone;
      if (k > known) { only = load(table.vertex, load(order.corner, k - 1u)); }
      only = select(select(only, of_previous, has_previous), of_next, has_next);
      let other = select(only, of_previous, has_next && has_previous && model_of(a, kMeanField) != 0u);
      for (var n = 1u; n < words; n++) { store(out, at + n, select(only, other, n > 3u)); }
    } else if (count == 1u && words > 4u) {
      for (var n = 1u; n < 4u; n++) { store(out, at + 3u + n, load(out, at + n)); }
    }
  }
}
fn store_parallelogram(out: View, at: u32, count: u32, found: Parallelogram) -> u32 {
  store(out, at + 3u * count + 1u, found.a);
  store(out, at + 3u * count + 2u, found.b);
  store(out, at + 3u * count + 3u, found.far);
  return count + 1u;
}

// Computes values, one after the other, and puts raw ones to their vertices. One thread for each attribute.
@compute @workgroup_size(kStreamsPerGroup)
fn create(@builtin(global_invocation_id) id: vec3u) {
  if (id.x >= window.count) { return; }
  let i = window.first + id.x;
  let s = streams[i];
  if (!is_fine(i) || id.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + id.y];
  let table = table_of(s, i, group_of(s, a.group));
  let values = values_of(a);
  let corrections = corrections_of(a);
  let width = a.value_components;
  if (model_of(a, kStoredSchemeField) == kSchemeRaw) {
    var before = kNone;
    for (var k = 0u; k < table.count; k++) {
      let out = width * load(table.vertex, load(table.corner, k));
      for (var c = 0u; c < width; c++) {
        var value = signed_of_symbol(load(corrections, width * k + c));
        if (before != kNone) { value += i32(load(values, before + c)); }
        store(values, out + c, u32(value));
      }
      before = out;
    }
  }
  if (model_of(a, kByCreationField) == 0u) { return; }
  let order = order_of(s, a);
  let known = known_count(order);
  let words = model_of(a, kPredictorWordsField);
  let by = View(model_of(a, kPredictorsField), words * s.point_count);
  let reach = model_of(a, kReachField);
  for (var k = known; k < table.count; k++) {
    let at = words * (k - known);
    let out = width * load(table.vertex, load(order.corner, k));
    for (var c = 0u; c < width; c++) {
      var value = predicted_by(values, width, c, by, at + 1u, reach);
      if (words > 4u) { value += (predicted_by(values, width, c, by, at + 4u, reach) - value) >> 1u; }
      store(values, out + c, u32(value + signed_of_symbol(load(corrections, width * (k - known) + c))));
    }
  }
  if (model_of(a, kHasGridField) == 0u) { return; }
  // Normals are on the grid, and have one name for each place on its edge.
  let grid = grid_of(head_of(a));
  for (var v = 0u; v < table.count; v++) {
    let place = vec2u(load(values, 2u * v), load(values, 2u * v + 1u));
    if (any(place >= vec2u(u32(grid.most)))) {
      fail(i);
      return;
    }
    let value = canonical(grid, vec2i(place));
    store(values, 2u * v, u32(value.x));
    store(values, 2u * v + 1u, u32(value.y));
  }
}
fn value_at(values: View, width: u32, c: u32, vertex: u32) -> i32 { return select(i32(load(values, width * vertex + c)), 0, vertex == kNone); }
// What one parallelogram predicts. Damped ones do not reach out as far.
fn predicted_by(values: View, width: u32, c: u32, by: View, at: u32, reach: u32) -> i32 {
  let a = value_at(values, width, c, load(by, at));
  let b = value_at(values, width, c, load(by, at + 1u));
  let p = a + b - value_at(values, width, c, load(by, at + 2u));
  return select(p, p - ((p - (a + ((b - a) >> 1u))) >> reach), reach > 0u);
}
`;
