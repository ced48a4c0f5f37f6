// Results (src/core/value_writer.h): indices, and values of the attributes' types, to the bit what the CPU computes. The lanes of a
// group share a stream.
export const value_writer = /* wgsl */ `
@compute @workgroup_size(kLanes)
fn write_faces(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let i = window.first + group.x;
  let s = streams[i];
  if (!is_fine(i)) { return; }
  let point_at = point_at_of(s);
  let numbers = numbers_of(s);
  let references = references_of(s);
  for (var corner = lane; corner < 4u * s.face_count; corner += kLanes) {
    if ((corner & 3u) == 3u) { continue; }
    var number = load(numbers, load(point_at, corner));
    if (number >= s.mesh_points) { number = load(references, 2u * (number - s.mesh_points) + 1u); }
    results[s.indices + 3u * (s.first_face + (corner >> 2u)) + (corner & 3u)] = number;
  }
}

@compute @workgroup_size(kLanes)
fn write_values(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
  let i = window.first + group.x;
  let s = streams[i];
  if (!is_fine(i) || group.y >= s.attribute_count) { return; }
  let a = attributes[s.attributes + group.y];
  if (a.out == kNone) { return; }
  let table = table_of(s, i, group_of(s, a.group));
  let numbers = numbers_of(s);
  if (a.coding == kCodingQuantized && lane == 0u) {
    write_grid(a);
    if (a.is_grid != 0u && load(head_of(a), kBits) > 16u) { fail(i); }
  }
  var low = vec3i(0x7fffffff);
  var high = vec3i(-0x7fffffff - 1);
  for (var point = lane; point < s.point_count; point += kLanes) {
    let number = load(numbers, point);
    if (number >= s.mesh_points) { continue; }  // its owner writes it
    var vertex = point;
    if (s.data_count > 0u) { vertex = load(table.vertex, load(corner_of_point_of(s), point)); }
    write_value(a, table, vertex, a.out + a.stride * number);
    if (a.bounds == kNone) { continue; }
    let values = values_of(a);
    let place = vec3i(i32(load(values, 3u * vertex)), i32(load(values, 3u * vertex + 1u)), i32(load(values, 3u * vertex + 2u)));
    low = min(low, place);
    high = max(high, place);
  }
  if (a.bounds == kNone || any(low > high)) { return; }
  for (var k = 0u; k < 3u; k++) {
    atomicMin(&states[a.bounds + k], u32(low[k]) ^ 0x80000000u);
    atomicMax(&states[a.bounds + 3u + k], u32(high[k]) ^ 0x80000000u);
  }
}

// Writes the grid of an attribute: its number of bits, its step and its origin.
fn write_grid(a: Attribute) {
  let head = head_of(a);
  atomicStore(&states[a.grid], load(head, kBits));
  atomicStore(&states[a.grid + 1u], load(head, kStep));
  for (var k = 0u; k < a.components; k++) { atomicStore(&states[a.grid + 2u + k], origin_of(a, k)); }
}

fn write_value(a: Attribute, table: Table, vertex: u32, out: u32) {
  let values = values_of(a);
  if (a.coding == kCodingNormal) {
    let vector = unit_vector(load(head_of(a), kStep), i32(load(values, 2u * vertex)), i32(load(values, 2u * vertex + 1u)));
    for (var k = 0u; k < 3u; k++) { results[out + k] = vector[k]; }
  } else if (a.coding == kCodingQuantized && a.is_grid == 0u) {
    let step = load(head_of(a), kStep);
    for (var k = 0u; k < a.components; k++) {
      results[out + k] = add(multiply(float_of(i32(load(values, a.components * vertex + k))), step), origin_of(a, k));
    }
  } else {
    // Integers, or bytes of the stream, packed to words.
    let width = a.out_bytes;
    var word = 0u;
    for (var b = 0u; b < a.components * width; b++) {
      var byte = 0u;
      if (a.coding == kCodingRaw) {
        byte = byte_at(load(head_of(a), kAt) + load(table.rank, vertex) * a.components * width + b);
      } else {
        byte = (load(values, a.components * vertex + b / width) >> (8u * (b % width))) & 0xffu;
      }
      word |= byte << (8u * (b & 3u));
      if ((b & 3u) == 3u) {
        results[out + b / 4u] = word;
        word = 0u;
      }
    }
    if (((a.components * width) & 3u) != 0u) { results[out + a.components * width / 4u] = word; }
  }
}

// The unit vector at a place of an octahedral grid, whose places are "scale" apart.
fn unit_vector(scale: u32, s: i32, t: i32) -> vec3u {
  const kOne = 0x3f800000u;
  const kMinusOne = 0xbf800000u;
  const kShort = 0x358637bdu;  // the last number below 1e-6
  var y = add(multiply(float_of(s), scale), kMinusOne);
  var z = add(multiply(float_of(t), scale), kMinusOne);
  let x = add(add(kOne, negate(select(y, negate(y), is_negative(y)))), negate(select(z, negate(z), is_negative(z))));
  var fold = negate(x);
  fold = select(fold, 0u, is_negative(fold));
  y = add(y, select(negate(fold), fold, is_negative(y)));
  z = add(z, select(negate(fold), fold, is_negative(z)));
  let square = add(add(multiply(x, x), multiply(y, y)), multiply(z, z));
  if (square <= kShort) { return vec3u(0u); }
  let inverse = divide(kOne, square_root(square));
  return vec3u(multiply(x, inverse), multiply(y, inverse), multiply(z, inverse));
}
`;
