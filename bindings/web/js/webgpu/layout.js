// The records of a batch as shaders read them, and where in the device's memory each stream has its arrays.
import { kCodingInteger, kCodingNormal, kCodingQuantized, kCodingRaw } from './stream_head.js';

export const kStreamFields = ['face_count', 'point_count', 'reference_count', 'symbol_count', 'vertex_limit', 'events', 'event_count', 'symbols',
  'end', 'start_faces', 'seams', 'data_count', 'body', 'groups', 'group_count', 'attributes', 'attribute_count', 'opposite', 'vertex',
  'border', 'scratch', 'scratch_count', 'numbers', 'references', 'point_at', 'cut', 'first_face', 'first_point', 'mesh_points', 'has_walk',
  'walk', 'stitch', 'stitch_end', 'first_stream', 'indices',
  'lists', 'listed', 'valences'];
export const kAttributeFields = ['group', 'coding', 'components', 'value_components', 'type_bytes', 'position', 'head', 'corrections', 'values',
  'value_room', 'slots', 'slot_room', 'buckets', 'bucket_bits', 'out', 'out_bytes', 'stride', 'is_grid', 'grid', 'bounds'];
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

// The group whose walk a group has: groups that have the mesh's table share one for each kind of walk.
const walker = (groups, g) => (groups[g].per_corner ? g : groups.findIndex(({ per_corner, by_degree }) => !per_corner && by_degree === groups[g].by_degree));
const is_walked = (groups, g) => g === 0 || walker(groups, g) === g;
const walk_count = (groups) => groups.reduce((count, _, g) => count + (is_walked(groups, g) ? 1 : 0), 0);
// Words of a walk over a group's table: a bit for each face, and the faces that wait, in several stacks for a walk by prediction degree,
// which also has the degree of each vertex.
const walk_words = ({ by_degree }, { face_count, point_count }) =>
  (face_count >> 5) + 1 + (by_degree ? 2 * (2 * face_count + 1) + point_count : face_count + 1);
const all_walk_words = (head) => head.groups.reduce((sum, group, g) => sum + (is_walked(head.groups, g) ? walk_words(group, head) : 0), 0);
// Of connectivity, walks and borders, one after the other.
const scratch_words = (head) =>
  Math.max((head.events.length > 0 ? 3 : 2) * (head.symbol_count + 1), all_walk_words(head), 2 * head.point_count);
const point_words = ({ seams, face_count, point_count }) => (seams.length > 0 ? 4 * face_count + 2 * point_count : 0);
const cut_words = ({ seams, face_count, point_count }) => seams.length * (8 * face_count + point_count + kDataWords);
// Of a valence traversal: the symbols of its lists, and the valences of vertices.
const listed_words = ({ lists, symbol_count }) => (lists.length > 0 ? symbol_count : 0);
const valence_words = ({ lists, vertex_limit }) => (lists.length > 0 ? vertex_limit + 3 : 0);
// Of an attribute: the components of a value, the words of its values (which its symbols use first), the slots of the symbol table, and
// the bits of a bucket of that table.
export const value_components = ({ coding, components }) => (coding === kCodingNormal ? 2 : components);
const value_room = (attribute, { point_count }) => point_count * value_components(attribute);
const slot_room = (values, { stream_bytes }) => Math.min(values, stream_bytes);
const bucket_bits = (values) => (values < 1024 ? 8 : 10);
function attribute_words(attribute, head) {
  if (attribute.coding === kCodingRaw) return kHeadWords;
  const values = value_room(attribute, head);
  return kHeadWords + 2 * values + 2 * slot_room(values, head) + 2 + (1 << bucket_bits(values));
}

/** Adds the words of a stream's records in a batch: of lists in `plan`, of itself, of its attributes, and of its walk. */
export function add_record_words(sizes, { events, seams, lists, groups, attributes, point_count }) {
  sizes[0] += 3 * events.length + 4 * (1 + seams.length) + kGroupWords * groups.length;
  for (const list of lists) sizes[0] += 1 + list.length;
  sizes[1] += kStreamFields.length;
  sizes[2] += kAttributeFields.length * attributes.length;
  sizes[3] += point_count;
}

/** The words of memory that a stream takes. */
export function stream_words(head) {
  const { face_count, point_count, reference_count } = head;
  let words = 8 * face_count + 2 * (head.vertex_limit + 3) + scratch_words(head) + point_count + 2 * reference_count + 1 + point_words(head) +
    cut_words(head) + listed_words(head) + valence_words(head) + walk_count(head.groups) * (2 * point_count + 1);
  for (const attribute of head.attributes) words += attribute_words(attribute, head);
  return words;
}

/** What a batch of containers needs: records, and sizes of buffers. */
export class Layout {
  #most_memory;
  #used = 0;  // of the window
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
    if (lists.length === 0) return kNone;
    const { plan } = this, at = plan.more(lists.length);
    for (const [i, [count, precision, symbols_at, ...rest]] of lists.entries()) plan.words[at + i] = plan.append([count, precision, symbols_at + bytes_at, ...rest]);
    return at;
  }
  // Appends the groups of a stream, and returns their place. Walks have their words from `walk` on.
  #add_groups(head, walk) {
    const { groups } = head, { words } = this.plan, begin = this.plan.more(kGroupWords * groups.length);
    for (let g = 0, at = begin; g < groups.length; ++g, at += kGroupWords) {
      const { data, per_corner, by_degree, first, count } = groups[g], of = g === 0 ? 0 : walker(groups, g), has_walk = of === g;
      words[at] = per_corner ? data + 1 : 0, words[at + 1] = first, words[at + 2] = count;
      words[at + 3] = has_walk ? this.take(2 * head.point_count + 1) : words[begin + kGroupWords * of + 3];
      words[at + 4] = has_walk ? walk : kNone, words[at + 5] = by_degree ? 1 : 0;
      if (has_walk) walk += walk_words(groups[g], head);
    }
    return begin;
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
    const { plan } = this, { symbol_count, vertex_limit, events, symbols, lists, start_faces, seams, groups, attributes, body } = head;
    const { face_count, point_count, reference_count } = head, { bytes_at } = place;
    let window = this.windows.at(-1);
    if (window === undefined || this.#used + words > this.#most_memory || window.count === kMostStreamsOfAWindow) {
      this.windows.push((window = { first: this.streams_added, count: 0 }));
      this.#used = 0;
    }
    ++window.count;
    this.memory_words = Math.max(this.memory_words, this.#used + words);
    this.list_count = Math.max(this.list_count, lists.length);
    this.data_count = Math.max(this.data_count, seams.length);
    this.group_count = Math.max(this.group_count, groups.length);
    this.attribute_count = Math.max(this.attribute_count, attributes.length);

    const events_at = plan.length;
    for (let i = 0; i < events.length; ++i) plan.append(events[i]);
    const start_at = this.#add_bits(start_faces, bytes_at), seams_at = plan.length;
    for (let i = 0; i < seams.length; ++i) this.#add_bits(seams[i], bytes_at);
    const lists_at = this.#add_lists(lists, bytes_at), scratch_count = scratch_words(head), s = this.streams.words;
    let at = this.streams.more(kStreamFields.length);
    // In the order of kStreamFields. Fields that are places take their words.
    s[at++] = face_count, s[at++] = point_count, s[at++] = reference_count, s[at++] = symbol_count, s[at++] = vertex_limit;
    s[at++] = events_at, s[at++] = events.length, s[at++] = symbols + bytes_at, s[at++] = stream_at[stream + 1] + bytes_at;
    s[at++] = start_at, s[at++] = seams_at, s[at++] = seams.length, s[at++] = body + bytes_at;
    const of_groups = at;
    at += 2;
    s[at++] = this.attributes.length / kAttributeFields.length, s[at++] = attributes.length;
    s[at++] = this.take(4 * face_count), s[at++] = this.take(4 * face_count), s[at++] = this.take(2 * (vertex_limit + 3));
    const scratch = (s[at++] = this.take(scratch_count));
    s[at++] = scratch_count, s[at++] = this.take(point_count), s[at++] = this.take(2 * reference_count + 1);
    s[at++] = this.take(point_words(head)), s[at++] = this.take(cut_words(head));
    s[of_groups] = this.#add_groups(head, scratch), s[of_groups + 1] = groups.length;
    s[at++] = first_faces[stream], s[at++] = first_points[stream], s[at++] = place.mesh_points, s[at++] = place.has_walk, s[at++] = this.walk_words;
    s[at++] = stitch_at[stream] + bytes_at, s[at++] = stitch_at[stream + 1] + bytes_at, s[at++] = place.first_stream, s[at++] = place.indices;
    s[at++] = lists_at, s[at++] = this.take(listed_words(head)), s[at++] = this.take(valence_words(head));
    this.walk_words += point_count;
    let position = 0;  // one more than the number of the positions before an attribute
    for (let i = 0; i < attributes.length; ++i) {
      this.add_attribute(attributes[i], head, position, outputs[i], kGridWords * stream);
      if (position === 0 && attributes[i].semantic === 0) position = i + 1;
    }
  }
  add_attribute(attribute, head, position, { out, out_bytes, stride, is_grid, grid, bounds }, grid_offset) {
    const { group, coding, components, type_bytes } = attribute, is_raw = coding === kCodingRaw, values = is_raw ? 0 : value_room(attribute, head);
    const slots = slot_room(values, head), bits = bucket_bits(values), a = this.attributes.words;
    let at = this.attributes.more(kAttributeFields.length);
    // In the order of kAttributeFields.
    a[at++] = group, a[at++] = coding, a[at++] = components, a[at++] = value_components(attribute), a[at++] = type_bytes, a[at++] = position;
    a[at++] = this.take(kHeadWords), a[at++] = is_raw ? 0 : this.take(values), a[at++] = is_raw ? 0 : this.take(values), a[at++] = values;
    a[at++] = is_raw ? 0 : this.take(2 * slots + 2), a[at++] = slots, a[at++] = is_raw ? 0 : this.take(1 << bits), a[at++] = bits;
    a[at++] = out, a[at++] = out_bytes, a[at++] = stride, a[at++] = is_grid, a[at++] = grid + (out === kNone ? 0 : grid_offset), a[at++] = bounds;
  }
}
