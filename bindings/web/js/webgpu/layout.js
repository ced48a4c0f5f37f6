// The records of a batch as shaders read them, and where in the device's memory each stream has its arrays.
import { kCodingInteger, kCodingNormal, kCodingQuantized, kCodingRaw } from './stream_head.js';

export const kStreamFields = ['face_count', 'point_count', 'reference_count', 'symbol_count', 'vertex_limit', 'events', 'event_count', 'symbols',
  'end', 'start_faces', 'seams', 'data_count', 'body', 'groups', 'group_count', 'attributes', 'attribute_count', 'opposite', 'vertex',
  'border', 'scratch', 'scratch_count', 'numbers', 'references', 'point_at', 'cut', 'first_face', 'first_point', 'mesh_points', 'has_walk',
  'walk', 'stitch', 'stitch_end', 'first_stream', 'indices',
  'lists', 'listed', 'valences'];
export const kAttributeFields = ['group', 'coding', 'components', 'value_components', 'type_bytes', 'position', 'head', 'corrections', 'values',
  'value_room', 'slots', 'slot_room', 'buckets', 'bucket_bits', 'out', 'out_bytes', 'stride', 'is_grid', 'grid', 'bounds'];
const kGroupsField = kStreamFields.indexOf('groups');
// What the device finds out of an attribute.
const kHeadFields = ['kCount', 'kScheme', 'kTransform', 'kKind', 'kAt', 'kSize', 'kRansState', 'kPrecision', 'kSlotCount', 'kLow', 'kHigh',
  'kOrigin', 'kBits', 'kStep', 'kOrientations'];
// Behind them a block of bits, which has four words, and for parallelograms four counts of flags with their blocks.
const kFlips = kHeadFields.length, kCreases = kFlips + 4, kHeadWords = kCreases + 4 * 5;
export const kGroupWords = 6;
const kDataWords = 2;
// Groups of one dispatch.
const kMostStreamsOfAWindow = 65535;
export const kNone = 0xffffffff, kStateWords = 4, kGridWords = 6, kBoundsWords = 6;

const struct = (name, fields) => `struct ${name} {${fields.map((field) => ` ${field}: u32`).join(',')} }\n`;
export const constants = (numbers) => Object.entries(numbers).map(([name, value]) => `const ${name} = ${value}u;\n`).join('');
/** Draco's numbers, and kSchemeNone. */
export const schemes = { kStoredNone: 254, kSchemeNone: 255, kSchemeDifference: 0, kSchemeParallelogram: 1, kSchemeParallelograms: 4, kSchemeTexCoords: 5,
  kSchemeGeometricNormal: 6, kTransformWrap: 1, kTransformCanonicalized: 3 };
/** The records in WGSL, and the numbers that both sides share. */
export const records = struct('Stream', kStreamFields) + struct('Attribute', kAttributeFields) +
  constants(Object.fromEntries(kHeadFields.map((name, i) => [name, i]))) +
  constants({ kFlips, kCreases, kHeadWords, kGroupWords, kCodingRaw, kCodingInteger, kCodingQuantized, kCodingNormal,
    ...schemes, kKindPlain: 0, kKindRaw: 1, kKindTagged: 2 });

/** Words of 32 bits. There is room for as many as will be appended: a test compares both numbers. */
class Words {
  length = 0;

  constructor(room) {
    this.words = new Uint32Array(room);
  }
  /** The place of `count` more words. */
  more(count) {
    return (this.length += count) - count;
  }
  /** Appends numbers, and returns the place of the first. */
  append(numbers) {
    const at = this.more(numbers.length);
    this.words.set(numbers, at);
    return at;
  }
}

// Words of a walk over a group's table: a bit for each face, and the faces that wait, in several stacks for a walk by prediction degree,
// which also has the degree of each vertex.
const walk_words = (by_degree, face_count, point_count) => (face_count >> 5) + 1 + (by_degree ? 2 * (2 * face_count + 1) + point_count : face_count + 1);
// Words of a stream with seams: for points, and for each of its data.
const point_words = (face_count, point_count) => 4 * face_count + 2 * point_count;
const cut_words = (face_count, point_count) => 8 * face_count + point_count + kDataWords;
// Words of an attribute: those of its values (which its symbols use first), and of the symbol table. `bits` are those of a bucket.
const bucket_bits = (values) => (values < 1024 ? 8 : 10);
const attribute_words = (values, slots, bits) => 2 * values + 2 * slots + 2 + (1 << bits);

/** Adds the words of a stream's records in a batch: of lists in `plan`, of itself, of its attributes, and of its walk. */
export function add_record_words(sizes, { events, seams, lists, groups, attributes, point_count }) {
  sizes[0] += 3 * events.length + 4 * (1 + seams.length) + kGroupWords * groups.length;
  for (const list of lists) sizes[0] += 1 + list.length;
  sizes[1] += kStreamFields.length;
  sizes[2] += kAttributeFields.length * attributes.length;
  sizes[3] += point_count;
}

/** The words of memory that a stream takes. Sets scratch_count: those of connectivity, walks and borders, one after the other. */
export function stream_words(head) {
  const { face_count, point_count, vertex_limit, symbol_count, stream_bytes, seams, lists, shape } = head;
  const { walks, degree_walks, value_components } = shape;
  let scratch = (head.events.length > 0 ? 3 : 2) * (symbol_count + 1), of_walks = walks * walk_words(false, face_count, point_count);
  if (degree_walks > 0) of_walks += degree_walks * walk_words(true, face_count, point_count);
  if (scratch < of_walks) scratch = of_walks;
  if (scratch < 2 * point_count) scratch = 2 * point_count;
  head.scratch_count = scratch;
  let words = 8 * face_count + 2 * (vertex_limit + 3) + scratch + point_count + 2 * head.reference_count + 1 + (walks + degree_walks) * (2 * point_count + 1);
  if (seams.length > 0) words += point_words(face_count, point_count) + seams.length * cut_words(face_count, point_count);
  if (lists.length > 0) words += symbol_count + vertex_limit + 3;  // the symbols of lists, and valences
  for (let i = 0; i < value_components.length; ++i) {
    const values = value_components[i] * point_count;
    words += kHeadWords + (value_components[i] === 0 ? 0 : attribute_words(values, values < stream_bytes ? values : stream_bytes, bucket_bits(values)));
  }
  return words;
}

/** What a batch of containers needs: records, and sizes of buffers. */
export class Layout {
  #most_memory;
  #used = 0;       // of the window
  #window = null;  // the last one
  #shape = null;   // of the last stream
  windows = [];  // { first, count }: streams that are in memory at one time
  memory_words = 0;
  walk_words = 0;
  result_words = 0;
  list_count = 0;  // the most of a stream, also below
  data_count = 0;
  group_count = 0;
  attribute_count = 0;

  /** @param {number} most_memory in words @param {{ stream_count: number, sizes: number[] }[]} plans that are placed here */
  constructor(most_memory, plans) {
    const sum = (of) => plans.reduce((all, plan) => all + of(plan), 0), [plan, streams, attributes] = [0, 1, 2].map((k) => new Words(sum(({ sizes }) => sizes[k])));
    this.#most_memory = most_memory;
    this.state_words = kStateWords * sum(({ stream_count }) => stream_count);
    Object.assign(this, { plan, streams, attributes });
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
  /** Takes words of memory of the stream that is added, and returns their place. */
  take(words) {
    return (this.#used += words) - words;
  }

  // Appends a run of bits of read_stream_head, and returns its place.
  #add_bits(bits, bytes_at) {
    const { words } = this.plan, at = this.plan.more(4);
    words[at] = bits[0], words[at + 1] = bits[1] + bytes_at, words[at + 2] = bits[2], words[at + 3] = bits[3];
    return at;
  }
  // Appends the lists of a valence traversal after the places where they are, and returns the place of those.
  #add_lists(lists, bytes_at) {
    const { plan } = this, at = plan.more(lists.length);
    for (const [i, [count, precision, symbols_at, ...rest]] of lists.entries()) plan.words[at + i] = plan.append([count, precision, symbols_at + bytes_at, ...rest]);
    return at;
  }
  // Appends the groups of a stream. Walks have their words from `walk` on.
  #add_groups({ groups, shape: { walkers }, face_count, point_count }, walk) {
    const { words } = this.plan, begin = this.plan.more(kGroupWords * groups.length);
    for (let g = 0, at = begin; g < groups.length; ++g, at += kGroupWords) {
      const group = groups[g], of = walkers[g], has_walk = of === g;
      words[at] = group.per_corner ? group.data + 1 : 0, words[at + 1] = group.first, words[at + 2] = group.count;
      words[at + 3] = has_walk ? this.take(2 * point_count + 1) : words[begin + kGroupWords * of + 3];
      words[at + 4] = has_walk ? walk : kNone, words[at + 5] = group.by_degree ? 1 : 0;
      if (has_walk) walk += walk_words(group.by_degree, face_count, point_count);
    }
    return begin;
  }

  // Windows, and the most that streams have.
  #begin_stream({ lists, seams, groups, attributes, shape }, words) {
    const used = this.#used + words;
    if (this.#window === null || used > this.#most_memory || this.#window.count === kMostStreamsOfAWindow) {
      this.windows.push((this.#window = { first: this.streams_added, count: 0 }));
      this.#used = 0;
    }
    ++this.#window.count;
    if (this.memory_words < this.#used + words) this.memory_words = this.#used + words;
    if (this.list_count < lists.length) this.list_count = lists.length;
    if (this.#shape === shape) return;
    this.#shape = shape;
    this.data_count = Math.max(this.data_count, seams.length);
    this.group_count = Math.max(this.group_count, groups.length);
    this.attribute_count = Math.max(this.attribute_count, attributes.length);
  }

  /**
   * Adds a stream. Nothing is made for it but its words, because there are thousands.
   * @param {object} head of read_stream_head, with the counts of the directory
   * @param {number} words of stream_words
   * @param {object} place what its container gives all streams: bytes_at, mesh_points, has_walk, first_stream, indices
   * @param {object[]} outputs of its attributes: out, out_bytes, stride, is_grid, grid (of the first stream), bounds
   * @param {number} stream its number in the container
   * @param {object} directory of the container
   */
  add_stream(head, words, place, outputs, stream, { stream_at, stitch_at, first_faces, first_points }) {
    this.#begin_stream(head, words);
    const { events, seams, lists, attributes, face_count, point_count, vertex_limit, scratch_count, shape: { positions } } = head, { bytes_at } = place;
    const { plan } = this, s = this.streams.words, events_at = plan.length, data_count = seams.length;
    for (let i = 0; i < events.length; ++i) {
      const event = events[i], at = plan.more(3);
      plan.words[at] = event[0], plan.words[at + 1] = event[1], plan.words[at + 2] = event[2];
    }
    const start_at = this.#add_bits(head.start_faces, bytes_at), seams_at = plan.length;
    for (let i = 0; i < data_count; ++i) this.#add_bits(seams[i], bytes_at);
    const lists_at = lists.length > 0 ? this.#add_lists(lists, bytes_at) : kNone;
    const begin = this.streams.more(kStreamFields.length);
    let at = begin, used = this.#used;
    // In the order of kStreamFields. Fields that are places take their words.
    s[at++] = face_count, s[at++] = point_count, s[at++] = head.reference_count, s[at++] = head.symbol_count, s[at++] = vertex_limit;
    s[at++] = events_at, s[at++] = events.length, s[at++] = head.symbols + bytes_at, s[at++] = stream_at[stream + 1] + bytes_at;
    s[at++] = start_at, s[at++] = seams_at, s[at++] = data_count, s[at++] = head.body + bytes_at, ++at, s[at++] = head.groups.length;
    s[at++] = this.attributes.length / kAttributeFields.length, s[at++] = attributes.length;
    s[at++] = used, s[at++] = used += 4 * face_count, s[at++] = used += 4 * face_count;
    const scratch = (s[at++] = used += 2 * (vertex_limit + 3));
    s[at++] = scratch_count, s[at++] = used += scratch_count, s[at++] = used += point_count, s[at++] = used += 2 * head.reference_count + 1;
    if (data_count > 0) used += point_words(face_count, point_count);
    s[at++] = used;
    if (data_count > 0) used += data_count * cut_words(face_count, point_count);
    this.#used = used;
    s[begin + kGroupsField] = this.#add_groups(head, scratch);
    s[at++] = first_faces[stream], s[at++] = first_points[stream], s[at++] = place.mesh_points, s[at++] = place.has_walk, s[at++] = this.walk_words;
    s[at++] = stitch_at[stream] + bytes_at, s[at++] = stitch_at[stream + 1] + bytes_at, s[at++] = place.first_stream, s[at++] = place.indices;
    s[at++] = lists_at, s[at++] = this.take(lists.length > 0 ? head.symbol_count : 0), s[at++] = this.take(lists.length > 0 ? vertex_limit + 3 : 0);
    this.walk_words += point_count;
    for (let i = 0; i < attributes.length; ++i) this.add_attribute(attributes[i], head, i, outputs[i], kGridWords * stream);
  }
  add_attribute({ group, coding, components, type_bytes }, { shape, point_count, stream_bytes }, i, output, grid_offset) {
    const value_components = shape.value_components[i], values = value_components * point_count, slots = values < stream_bytes ? values : stream_bytes;
    const a = this.attributes.words, bits = bucket_bits(values), has_values = value_components > 0;  // values that are stored as they are have no arrays
    let at = this.attributes.more(kAttributeFields.length), used = this.#used;
    // In the order of kAttributeFields.
    a[at++] = group, a[at++] = coding, a[at++] = components, a[at++] = has_values ? value_components : components, a[at++] = type_bytes;
    a[at++] = shape.positions[i], a[at++] = used, used += kHeadWords;
    a[at++] = has_values ? used : 0, a[at++] = has_values ? used += values : 0, a[at++] = values, a[at++] = has_values ? used += values : 0;
    a[at++] = slots, a[at++] = has_values ? used += 2 * slots + 2 : 0, a[at++] = bits;
    this.#used = has_values ? used + (1 << bits) : used;
    a[at++] = output.out, a[at++] = output.out_bytes, a[at++] = output.stride, a[at++] = output.is_grid;
    a[at++] = output.grid + (output.out === kNone ? 0 : grid_offset), a[at++] = output.bounds;
  }
}
