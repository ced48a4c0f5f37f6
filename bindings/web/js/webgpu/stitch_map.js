// The reader of a stitch map (src/core/stitch_reader.h): runs along borders, and pairs.
import { BitString, floor_log2, NumberKind, unfold } from './bit_string.js';
import { refuse } from './refusal.js';

export const kRunWords = 5;   // the first place, the length, the owner, its first place, whether places count up
export const kPairWords = 3;  // the point, the owner, the rank among the owner's points; of a repeat the other point

// Checks a number of 32 bits.
function checked(value) {
  if (value < 0 || value > 0xffffffff) refuse('a broken stitch map');
  return value;
}

/**
 * Reads the part of stream number `stream` from bytes [at, end), and appends its runs and pairs. Refuses what no stream may have.
 * @param {number[]} runs kRunWords numbers for each
 * @param {number[]} pairs kPairWords numbers for each: repeats first
 * @returns {number} the number of pairs that are repeats
 */
export function read_stitch_map(bytes, at, end, stream, point_count, reference_count, runs, pairs) {
  if (at === end) {
    if (reference_count > 0) refuse('a broken stitch map');
    return 0;
  }
  const bits = new BitString(bytes, at, end);
  const count = new NumberKind(0), back = new NumberKind(0), walk_skip = new NumberKind(1), length_kind = new NumberKind(1),
    start_step = new NumberKind(2), place = new NumberKind(point_count < 2 ? 0 : floor_log2(point_count) - 1),
    point_skip = new NumberKind(reference_count === 0 ? 0 : floor_log2(Math.floor(point_count / reference_count))),
    distance_kind = new NumberKind(1), rank_step = new NumberKind(1);
  let left = reference_count, next = 0, owner = -1, expected = 0, sign = -1;
  const owner_at = (distance) => {
    if (distance > stream) refuse('a broken stitch map');
    return stream - distance;
  };

  const run_count = bits.number(count);
  if (run_count > left) refuse('a broken stitch map');
  for (let i = 0; i < run_count; ++i) {
    const skip = bits.number(walk_skip), more = bits.number(length_kind);
    if (more >= left) refuse('a broken stitch map');
    const begin = checked(next + skip), length = more + 1, forward = more > 0 && bits.flag();
    let start;
    if (owner < 0 || bits.flag()) {
      owner = owner_at(bits.number(back));
      start = bits.number(place);
    } else {
      start = checked(expected + sign * (skip + bits.signed(start_step)));
    }
    if (forward ? start + length > 0xffffffff : start + 1 < length) refuse('a broken stitch map');
    left -= length;
    next = checked(begin + length);
    expected = forward ? start + length : start - length;
    sign = forward ? 1 : -1;
    runs.push(begin, length, owner, start, forward ? 1 : 0);
  }

  next = 0, owner = -1, sign = -1;
  // The first stream can refer to no other stream, so all its pairs are repeats.
  const pair_count = left === 0 || stream === 0 ? 0 : bits.number(count);
  if (pair_count > left) refuse('a broken stitch map');
  const repeat_count = left - pair_count, distances_differ = repeat_count > 0 && bits.flag();
  let distance = 0, rank = 0;
  for (let i = 0; i < left; ++i) {
    const point = checked(next + bits.number(point_skip));
    next = point + 1;
    if (i < repeat_count) {
      const coded = bits.number(distance_kind);
      distance = distances_differ ? checked(distance + unfold(coded)) : coded;
      if (distance >= point) refuse('a broken stitch map');
      pairs.push(point, stream, point - 1 - distance);
      if (i + 1 === repeat_count) next = 0;
    } else if (owner < 0 || bits.flag()) {
      owner = owner_at(bits.number(back) + 1);
      rank = bits.number(place);
      pairs.push(point, owner, rank);
    } else {
      const target = checked(rank + sign * (1 + bits.signed(rank_step)));
      sign = target < rank ? -1 : 1;
      rank = target;
      pairs.push(point, owner, rank);
    }
  }
  bits.finish();
  return repeat_count;
}
