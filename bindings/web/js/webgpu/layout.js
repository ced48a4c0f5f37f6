// The records of a batch as shaders read them, and where in the device's memory each stream has its arrays.
import { kPairWords, kRunWords } from './stitch_map.js';
import { kCodingInteger, kCodingNormal, kCodingQuantized, kCodingRaw } from './stream_head.js';

const kStreamFields = ['face_count', 'point_count', 'reference_count', 'symbol_count', 'vertex_limit', 'events', 'event_count', 'symbols',
  'end', 'start_faces', 'seams', 'data_count', 'body', 'groups', 'group_count', 'attributes', 'attribute_count', 'opposite', 'vertex',
  'border', 'scratch', 'scratch_count', 'numbers', 'references', 'point_at', 'cut', 'first_face', 'first_point', 'mesh_points', 'has_walk',
  'walk', 'runs', 'run_count', 'pairs', 'pair_count', 'repeat_count', 'first_stream', 'indices'];
const kAttributeFields = ['group', 'coding', 'components', 'value_components', 'type_bytes', 'position', 'head', 'corrections', 'values',
  'value_room', 'slots', 'slot_room', 'buckets', 'bucket_bits', 'out', 'out_bytes', 'stride', 'is_grid', 'grid', 'bounds'];
// What the device finds out of an attribute.
const kHeadFields = ['kCount', 'kScheme', 'kTransform', 'kKind', 'kAt', 'kSize', 'kRansState', 'kPrecision', 'kSlotCount', 'kLow', 'kHigh',
  'kOrigin', 'kBits', 'kStep', 'kOrientations', 'kFlips'];
const kHeadWords = kHeadFields.length + 3;  // kFlips has four
const kGroupWords = 5, kDataWords = 2;
// Groups of one dispatch.
const kMostStreamsOfAWindow = 65535;
export const kNone = 0xffffffff, kStateWords = 4, kGridWords = 6, kBoundsWords = 6;

const struct = (name, fields) => `struct ${name} {${fields.map((field) => ` ${field}: u32`).join(',')} }\n`;
const constants = (numbers) => Object.entries(numbers).map(([name, value]) => `const ${name} = ${value}u;\n`).join('');
/** The records in WGSL, and the numbers that both sides share. Schemes and transforms are Draco's. */
export const records = struct('Stream', kStreamFields) + struct('Attribute', kAttributeFields) +
  constants(Object.fromEntries(kHeadFields.map((name, i) => [name, i]))) +
  constants({ kHeadWords, kGroupWords, kRunWords, kPairWords, kCodingRaw, kCodingInteger, kCodingQuantized, kCodingNormal,
    kStoredNone: 254, kSchemeNone: 255, kSchemeDifference: 0, kSchemeParallelogram: 1, kSchemeTexCoords: 5, kSchemeGeometricNormal: 6,
    kTransformWrap: 1, kTransformCanonicalized: 3, kKindPlain: 0, kKindRaw: 1, kKindTagged: 2 });

/** Words of 32 bits, as many as are appended. */
class Words {
  #words = new Uint32Array(1024);
  length = 0;

  push(...words) {
    this.reserve(words.length).set(words);
  }
  reserve(count) {
    if (this.length + count > this.#words.length) {
      const larger = new Uint32Array(2 * (this.length + count));
      larger.set(this.view());
      this.#words = larger;
    }
    this.length += count;
    return this.#words.subarray(this.length - count, this.length);
  }
  view() {
    return this.#words.subarray(0, this.length);
  }
}

// Where a stream has its arrays, from place `used` of a window on: { arrays, walks, values, used }. `walks` are by group, `values` by
// attribute.
function arrange({ symbol_count, vertex_limit, events, seams, groups, attributes }, { face_count, point_count, reference_count, stream_bytes }, used) {
  const take = (words) => (used += words) - words;
  const arrays = { opposite: take(4 * face_count), vertex: take(4 * face_count), border: take(2 * (vertex_limit + 3)) };
  // Groups that have the mesh's table share one walk.
  const first_shared = groups.findIndex(({ per_corner }) => !per_corner);
  const is_walked = groups.map(({ per_corner }, g) => per_corner || g === first_shared);
  const walk_words = face_count + 1 + Math.floor(face_count / 32) + 1;
  // Of connectivity, walks and borders, one after the other.
  arrays.scratch_count = Math.max((events.length > 0 ? 3 : 2) * (symbol_count + 1), is_walked.filter((is) => is).length * walk_words, 2 * point_count);
  arrays.scratch = take(arrays.scratch_count);
  arrays.numbers = take(point_count);
  arrays.references = take(reference_count + 1);
  arrays.point_at = take(seams.length > 0 ? 4 * face_count + 2 * point_count : 0);
  arrays.cut = take(seams.length * (8 * face_count + point_count + kDataWords));
  let walk = arrays.scratch;
  const walks = is_walked.map((is) => (is ? { sequence: take(2 * point_count + 1), walk: (walk += walk_words) - walk_words } : { walk: kNone }));
  for (const of_group of walks) of_group.sequence ??= walks[first_shared].sequence;
  const values = attributes.map(({ coding, components }) => {
    const value_components = coding === kCodingNormal ? 2 : components, value_room = point_count * value_components;
    const slot_room = Math.min(value_room, stream_bytes), bucket_bits = value_room < 1024 ? 8 : 10, has_integers = coding !== kCodingRaw;
    const room = (words) => take(has_integers ? words : 0);
    return { value_components, value_room, slot_room, bucket_bits, head: take(kHeadWords), corrections: room(value_room), values: room(value_room),
      slots: room(2 * slot_room + 2), buckets: room(1 << bucket_bits) };
  });
  return { arrays, walks, values, used };
}
/** The words of memory that a stream takes. */
export const stream_words = (head, row) => arrange(head, row, 0).used;

/** What a batch of containers needs: records, and sizes of buffers. */
export class Layout {
  #most_memory;
  #used = 0;  // of the window
  plan = new Words();
  streams = new Words();
  attributes = new Words();
  windows = [];  // { first, count }: streams that are in memory at one time
  memory_words = 0;
  walk_words = 0;
  result_words = 0;
  data_count = 0;  // the most of a stream, also below
  group_count = 0;
  attribute_count = 0;

  /** @param {number} most_memory in words @param {number} stream_count of all containers */
  constructor(most_memory, stream_count) {
    this.#most_memory = most_memory;
    this.state_words = kStateWords * stream_count;
  }

  get streams_added() {
    return this.streams.length / kStreamFields.length;
  }
  // Take words of results and states; return their places.
  take_results(words) {
    return (this.result_words += words) - words;
  }
  take_states(words) {
    return (this.state_words += words) - words;
  }

  /**
   * Adds a stream.
   * @param {object} head of read_stream_head, with the places of bytes in the batch's buffer
   * @param {object} row counts of the directory, and what the record has beside
   * @param {{ runs: number[], pairs: number[], repeat_count: number }} references of read_stitch_map
   * @param {(attribute: object) => object} output of an attribute: out, out_bytes, stride, is_grid, grid, bounds
   */
  add_stream(head, row, { runs, pairs, repeat_count }, output) {
    const { symbol_count, vertex_limit, events, symbols, start_faces, seams, groups, attributes, body } = head;
    let arranged = arrange(head, row, this.#used), window = this.windows.at(-1);
    if (window === undefined || arranged.used > this.#most_memory || window.count === kMostStreamsOfAWindow) {
      arranged = arrange(head, row, 0);
      this.windows.push((window = { first: this.streams_added, count: 0 }));
    }
    const { arrays, walks, values, used } = arranged;
    ++window.count;
    this.#used = used;
    this.memory_words = Math.max(this.memory_words, used);
    this.data_count = Math.max(this.data_count, seams.length);
    this.group_count = Math.max(this.group_count, groups.length);
    this.attribute_count = Math.max(this.attribute_count, attributes.length);
    const listed = (numbers) => {
      const place = this.plan.length;
      this.plan.reserve(numbers.length).set(numbers);
      return place;
    };
    const of_groups = groups.flatMap(({ data, per_corner, first, count }, g) =>
      [per_corner ? data + 1 : 0, first, count, walks[g].sequence, walks[g].walk]);
    const record = { ...row, ...arrays, symbol_count, vertex_limit, events: listed(events.flat()), event_count: events.length, symbols,
      start_faces: listed(start_faces), seams: listed(seams.flat()), data_count: seams.length, body, groups: listed(of_groups),
      group_count: groups.length, attributes: this.attributes.length / kAttributeFields.length, attribute_count: attributes.length,
      walk: this.walk_words, runs: listed(runs), run_count: runs.length / kRunWords, pairs: listed(pairs), pair_count: pairs.length / kPairWords,
      repeat_count };
    this.walk_words += row.point_count;
    this.streams.push(...kStreamFields.map((field) => record[field]));
    const position = attributes.findIndex(({ semantic }) => semantic === 0);
    for (const [i, attribute] of attributes.entries()) {
      const of_attribute = { ...attribute, ...values[i], position: position >= 0 && position < i ? position + 1 : 0, ...output(attribute) };
      this.attributes.push(...kAttributeFields.map((field) => of_attribute[field]));
    }
  }
}
