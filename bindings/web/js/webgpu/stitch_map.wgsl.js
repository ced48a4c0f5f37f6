// The reader of a stitch map (src/core/stitch_reader.h, stitch_codes.h): which points of a stream are other streams' or come twice.
// Numbers that no stream of this decoder has, which are those from 2^24 on, are refused, so that sums fit 32 bits.
export const stitch_map = /* wgsl */ `
// Bits of the map of a stream. What is read past the end is 0; end_map() refuses it.
var<private> map_bit: u32;
var<private> map_is_broken: bool;
const kMostNumberBits = 24u;

fn read_map_bits(s: Stream, count: u32) -> u32 {  // at most 31
  let value = bits_at(s.stitch, map_bit, s.stitch_end) & ((1u << count) - 1u);
  map_bit += count;
  return value;
}
// A number of a kind, whose state is 16 times the order of its exponential Golomb code.
fn read_number(s: Stream, kind: ptr<function, u32>) -> u32 {
  let order = *kind >> 4u;
  let zeros = countTrailingZeros(bits_at(s.stitch, map_bit, s.stitch_end));
  if (zeros + order > kMostNumberBits) {
    map_is_broken = true;
    return 0u;
  }
  map_bit += zeros + 1u;
  let high = (1u << zeros) - 1u + read_map_bits(s, zeros);
  let value = (high << order) | read_map_bits(s, order);
  *kind = (3u * *kind + 16u * floor_log2(value)) >> 2u;
  return value;
}
fn floor_log2(value: u32) -> u32 { return 31u - countLeadingZeros(value | 1u); }
fn unfold(value: u32) -> i32 { return select(-i32(value >> 1u) - 1, i32(value >> 1u), (value & 1u) == 0u); }
fn is_place(value: i32) -> bool { return u32(value) < (1u << kMostNumberBits); }
// The unused bits of the last byte are 0, and nothing follows.
fn end_map(s: Stream) -> bool {
  let at = s.stitch + ((map_bit + 7u) >> 3u);
  return !map_is_broken && at == s.stitch_end && bits_at(s.stitch, map_bit, at) == 0u;
}

// A reference has two words: the stream that owns it, or its kind, and a place there.
const kIsPair = 0x80000000u;   // beside the owner: the place is a rank among the owner's points, not in its walk
const kIsRepeat = 0xffffffffu; // the place is a point of the stream itself, or the number of that in the mesh

// Makes a point of the stream its reference number r. Returns false if it is one already.
fn refer(s: Stream, r: u32, point: u32, owner: u32, place: u32) -> bool {
  if (point >= s.point_count || load(numbers_of(s), point) != kNone) { return false; }
  store(numbers_of(s), point, s.mesh_points + r);
  store(references_of(s), 2u * r, owner);
  store(references_of(s), 2u * r + 1u, place);
  return true;
}

// Reads the map of stream i, whose walk has "length" points. Returns false if it is broken; ranks and places in other walks are not
// checked here.
fn read_stitch_map(s: Stream, i: u32, walk: View, length: u32) -> bool {
  let stream = i - s.first_stream;
  var of_count = 0u;
  var of_back = 0u;
  var of_walk_skip = 16u;
  var of_length = 16u;
  var of_start_step = 32u;
  var of_place = 16u * max(floor_log2(s.point_count), 1u) - 16u;
  var of_point_skip = 16u * floor_log2(s.point_count / s.reference_count);
  var of_distance = 16u;
  var of_rank_step = 16u;
  map_bit = 0u;
  map_is_broken = false;

  var left = s.reference_count;
  var next = 0u;       // the lowest possible place or point
  var owner = kNone;
  var expected = 0;    // the place where the next run begins, if nothing lies between it and the last
  var sign = -1;
  let run_count = read_number(s, &of_count);
  if (run_count > left) { return false; }
  for (var run = 0u; run < run_count; run++) {
    let skip = read_number(s, &of_walk_skip);
    let count = 1u + read_number(s, &of_length);
    if (map_is_broken || count > left) { return false; }
    let begin = next + skip;
    let forward = count > 1u && read_map_bits(s, 1u) != 0u;
    var start = 0;
    if (owner == kNone || read_map_bits(s, 1u) != 0u) {
      let back = read_number(s, &of_back);
      if (back > stream) { return false; }
      owner = stream - back;
      start = i32(read_number(s, &of_place));
    } else {
      start = expected + sign * (i32(skip) + unfold(read_number(s, &of_start_step)));
    }
    sign = select(-1, 1, forward);
    expected = start + sign * i32(count);
    if (!is_place(start) || expected < -1 || begin > length || count > length - begin) { return false; }
    for (var k = 0u; k < count; k++) {
      if (!refer(s, s.reference_count - left + k, load(walk, begin + k), s.first_stream + owner, u32(start + sign * i32(k)))) { return false; }
    }
    left -= count;
    next = begin + count;
  }

  next = 0u;
  owner = kNone;
  sign = -1;
  // The first stream can refer to no other stream, so all its pairs are repeats.
  var pair_count = 0u;
  if (left > 0u && stream > 0u) { pair_count = read_number(s, &of_count); }
  if (pair_count > left) { return false; }
  let repeat_count = left - pair_count;
  let distances_differ = repeat_count > 0u && read_map_bits(s, 1u) != 0u;
  var distance = 0;
  var rank = 0;
  for (var k = 0u; k < repeat_count + pair_count; k++) {
    let point = next + read_number(s, &of_point_skip);
    next = point + 1u;
    var of_reference = kIsRepeat;
    var place = 0;
    if (k < repeat_count) {
      let coded = read_number(s, &of_distance);
      distance = select(i32(coded), distance + unfold(coded), distances_differ);
      place = i32(point) - 1 - distance;
      if (distance < 0) { return false; }
      if (k + 1u == repeat_count) { next = 0u; }
    } else {
      if (owner == kNone || read_map_bits(s, 1u) != 0u) {
        let back = 1u + read_number(s, &of_back);
        if (back > stream) { return false; }
        owner = stream - back;
        rank = i32(read_number(s, &of_place));
      } else {
        let following = rank + sign * (1 + unfold(read_number(s, &of_rank_step)));
        sign = select(1, -1, following < rank);
        rank = following;
      }
      of_reference = kIsPair | (s.first_stream + owner);
      place = rank;
    }
    if (!is_place(place) || !refer(s, s.reference_count - left + k, point, of_reference, u32(place))) { return false; }
  }
  return end_map(s);
}
`;
