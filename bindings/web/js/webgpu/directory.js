// The directory of a container (src/container/directory.h): where its streams and their stitch maps are, and what they count. All
// checks are those of src/container: what breaks a rule is refused.
import { head_of, kHeaderBytes } from '../head.js';
import { BitString, NumberKind } from './bit_string.js';
import { refuse } from './refusal.js';

// Columns of numbers, each stored as its distance from the number that the rows before let expect. Their functions call little, because
// V8 interprets them for the first thousands of numbers.

// Of numbers that have a base, which the row knows: the next one exceeds its base by the mean of earlier ones.
class Sums {
  #sixteenths = 0;
  #is_first = true;
  #kind;

  constructor(order) {
    this.#kind = new NumberKind(order);
  }
  next(bits, base) {
    const sixteenths = this.#sixteenths, expected = base + Math.floor(sixteenths / 16), value = (expected + bits.signed(this.#kind)) >>> 0;
    this.#sixteenths = this.#is_first ? 16 * (value - expected) : sixteenths + value - expected;
    this.#is_first = false;
    return value;
  }
}
// Of numbers that are roughly proportional to another number of the row.
class Ratios {
  #ratio = 0;  // in 1024ths
  #is_first = true;
  #kind;

  constructor(order) {
    this.#kind = new NumberKind(order);
  }
  next(bits, known) {
    const kMost = (1 << 17) - 1, scale = Math.max(known, 1), ratio = this.#ratio;
    const value = (Math.floor((ratio * scale) / 1024) + bits.signed(this.#kind)) >>> 0, sixty_fourths = Math.min(Math.floor((value * 64) / scale), kMost);
    this.#ratio = this.#is_first ? 16 * sixty_fourths : ratio + sixty_fourths - (ratio >> 4);
    this.#is_first = false;
    return value;
  }
}

// More streams would take sums of more bits than a number has, and have never been seen.
const kMostStreams = 1 << 20;

// The bytes that a number of stored bytes justifies: src/core/workspace.h.
const justified_bytes = (bytes) => 2 ** 26 + 4096 * bytes;

// The sections of a head by type, [begin, end), without the ones that a reader may skip: their types are from 128 on.
function find_sections(bytes, begin, end) {
  const kMayBeSkipped = 128, kMostLengthBytes = 5, sections = new Map();
  for (let at = begin, last = -1; at < end;) {
    const type = bytes[at++];
    if (type <= last) refuse('a broken head');
    last = type;
    let length = 0, i = 0;
    for (;; ++i) {
      if (at === end || i === kMostLengthBytes) refuse('a broken head');
      const byte = bytes[at++];
      length += (byte % 128) * 128 ** i;
      if (byte < 128) break;
    }
    if (length > end - at) refuse('a broken head');
    if (type < kMayBeSkipped) sections.set(type, [at, at + length]);
    at += length;
  }
  return sections;
}

/**
 * @param {Uint8Array} bytes of a whole container
 * @param {new (bytes: Uint8Array, sections: Map<number, number[]>) => object} [Tables] what condensed streams have in common
 *   (CondensedTables), which reads its own part of the directory; without it condensed patches are refused
 * @returns {{ stream_count: number, has_residue: boolean, has_references: boolean, faces: Uint32Array, points: Uint32Array, references: Uint32Array,
 *   stitch_at: Uint32Array, stream_at: Uint32Array, first_faces: Uint32Array, first_points: Uint32Array }} the places of stitch maps
 *   and streams, and the sums of faces and owned points, have one number more than there are streams
 */
export function read_directory(bytes, Tables) {
  const kVersion = 1, kResidue = 1;
  const { begin, end } = bytes.length < kHeaderBytes ? { begin: 0 } : head_of(bytes);
  if (begin === 0) refuse('not a container');
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), stream_count = view.getUint32(8, true);
  const flags = bytes[5];
  if (bytes[4] !== kVersion || flags > kResidue || view.getUint16(6, true) !== 0) refuse('an unknown version, flag or codec');
  if (end > bytes.length || stream_count === 0 || stream_count > 2 * (begin - kHeaderBytes)) refuse('a broken header');
  if (stream_count > kMostStreams) refuse('too many streams');
  const sections = find_sections(bytes, begin, end), tables = Tables && new Tables(bytes, sections);

  const bits = new BitString(bytes, kHeaderBytes, begin), skeletons = bits.number(new NumberKind(0));
  if (tables !== undefined) tables.begin_rows(bits, skeletons);
  else if (skeletons + sections.size > 0) refuse('condensed patches');
  const has_residue = flags === kResidue, numbers = () => new Uint32Array(stream_count), sums = () => new Uint32Array(stream_count + 1);
  const faces = numbers(), points = numbers(), references = numbers(), stitch_at = sums(), stream_at = sums(), first_faces = sums(),
    first_points = sums();
  const of_faces = new Sums(6), of_points = new Sums(3), of_references = new Sums(3), of_stitch = new Ratios(2), of_bytes = new Ratios(6);
  let stitch_bytes = 0, stream_bytes = 0, face_sum = 0, point_sum = 0, all_points = 0, reference_sum = 0;
  for (let i = 0; i < stream_count; ++i) {
    tables?.next_row(bits);
    const face_count = (faces[i] = of_faces.next(bits, 0));
    const point_count = (points[i] = of_points.next(bits, face_count >>> 1));
    const reference_count = (references[i] = of_references.next(bits, 0));
    const in_stitch = reference_count > 0 ? of_stitch.next(bits, reference_count) : 0, in_stream = of_bytes.next(bits, point_count);
    const is_residue = has_residue && i + 1 === stream_count;
    if (in_stream === 0 || (face_count === 0 && !is_residue) || reference_count > point_count ||
      (!is_residue && point_count > 3 * face_count)) refuse('a broken row of the directory');
    stitch_at[i] = stitch_bytes, stream_at[i] = stream_bytes;  // moved below
    first_faces[i] = face_sum, first_points[i] = point_sum;
    stitch_bytes += in_stitch, stream_bytes += in_stream;
    face_sum += face_count, point_sum += point_count - reference_count;
    all_points += point_count, reference_sum += reference_count;
    if (point_sum > 0xfffffffe || face_sum > 0xffffffff / 3 || end + stitch_bytes + stream_bytes > bytes.length)
      refuse('a broken directory');
  }
  bits.finish();
  if (end + stitch_bytes + stream_bytes !== bytes.length || point_sum + reference_sum > 0xffffffff ||
    (face_sum + all_points) * 16 > justified_bytes(stream_bytes)) refuse('a broken directory');
  stitch_at[stream_count] = stitch_bytes, stream_at[stream_count] = stream_bytes;
  first_faces[stream_count] = face_sum, first_points[stream_count] = point_sum;
  for (let i = 0; i <= stream_count; ++i) stitch_at[i] += end, stream_at[i] += end + stitch_bytes;
  return { tables, stream_count, has_residue, has_references: reference_sum > 0, faces, points, references, stitch_at, stream_at, first_faces, first_points };
}

/** Whether the stored bytes justify results of so many bytes. */
export const are_justified = (result_bytes, stored_bytes) => result_bytes <= justified_bytes(stored_bytes);
/** The same for the counts of one stream. */
export const is_justified_stream = (elements, stream_bytes) => elements * 16 <= justified_bytes(stream_bytes);
