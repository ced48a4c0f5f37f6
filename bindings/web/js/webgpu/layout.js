// The records of a batch as shaders read them, and where in the device's memory each stream has its arrays.
import { kPairWords, kRunWords } from './stitch_map.js';
import { kCodingInteger, kCodingNormal, kCodingQuantized, kCodingRaw } from './stream_head.js';

const kStreamFields = ['face_count', 'point_count', 'reference_count', 'symbol_count', 'vertex_limit', 'events', 'event_count', 'symbols',
  'end', 'start_faces', 'seams', 'data_count', 'body', 'groups', 'group_count', 'attributes', 'attribute_count', 'opposite', 'vertex',
  'border', 'scratch', 'scratch_count', 'numbers', 'references', 'point_at', 'cut', 'first_face', 'first_point', 'mesh_points', 'has_walk',
  'walk', 'runs', 'run_count', 'pairs', 'pair_count', 'repeat_count', 'first_stream', 'indices',
  'lists', 'listed', 'valences'];
const kAttributeFields = ['group', 'coding', 'components', 'value_components', 'type_bytes', 'position', 'head', 'corrections', 'values',
  'value_room', 'slots', 'slot_room', 'buckets', 'bucket_bits', 'out', 'out_bytes', 'stride', 'is_grid', 'grid', 'bounds'];
// What the device finds out of an attribute.
const kHeadFields = ['kCount', 'kScheme', 'kTransform', 'kKind', 'kAt', 'kSize', 'kRansState', 'kPrecision', 'kSlotCount', 'kLow', 'kHigh',
  'kOrigin', 'kBits', 'kStep', 'kOrientations'];
// Behind them a block of bits, which has four words, and for parallelograms four counts of flags with their blocks.
const kFlips = kHeadFields.length, kCreases = kFlips + 4, kHeadWords = kCreases + 4 * 5;
const kGroupWords = 6, kDataWords = 2;
// Groups of one dispatch.
const kMostStreamsOfAWindow = 65535;
export const kNone = 0xffffffff, kStateWords = 4, kGridWords = 6, kBoundsWords = 6;

const struct = (name, fields) => `struct ${name} {${fields.map((field) => ` ${field}: u32`).join(',')} }\n`;
const constants = (numbers) => Object.entries(numbers).map(([name, value]) => `const ${name} = ${value}u;\n`).join('');
/** The records in WGSL, and the numbers that both sides share. Schemes and transforms are Draco's. */
export const records = struct('Stream', kStreamFields) + struct('Attribute', kAttributeFields) +
  constants(Object.fromEntries(kHeadFields.map((name, i) => [name, i]))) +
  constants({ kFlips, kCreases, kHeadWords, kGroupWords, kRunWords, kPairWords, kCodingRaw, kCodingInteger, kCodingQuantized, kCodingNormal,
    kStoredNone: 254, kSchemeNone: 255, kSchemeDifference: 0, kSchemeParallelogram: 1, kSchemeParallelograms: 4, kSchemeTexCoords: 5, kSchemeGeometricNormal: 6,
    kTransformWrap: 1, kTransformCanonicalized: 3, kKindPlain: 0, kKindRaw: 1, kKindTagged: 2 });

/** Words of 32 bits, as many as are appended. */
class Words {
  #words = new Uint32Array(1024);
  length = 0;

  // A view of `count` more words.
  #more(count) {
    if (this.length + count > this.#words.length) {
      const larger = new Uint32Array(2 * (this.length + count));
      larger.set(this.view());
      this.#words = larger;
    }
    this.length += count;
  }
  /** Appends numbers, and returns the place of the first. */
  append(numbers) {
    const at = this.length;
    this.#more(numbers.length);
    const words = this.#words;
    for (let i = 0; i < numbers.length; ++i) words[at + i] = numbers[i];
    return at;
  }
  set(at, word) {
    this.#words[at] = word;
  }
  view() {
    return this.#words.subarray(0, this.length);
  }
}

// The group whose walk a group has: groups that have the mesh's table share one for each kind of walk.
const walker = (groups, g) => (groups[g].per_corner ? g : groups.findIndex(({ per_corner, by_degree }) => !per_corner && by_degree === groups[g].by_degree));
const is_walked = (groups, g) => walker(groups, g) === g;
const walk_count = (groups) => groups.reduce((count, _, g) => count + (is_walked(groups, g) ? 1 : 0), 0);
// Words of a walk over a group's table: a bit for each face, and the faces that wait, in several stacks for a walk by prediction degree,
// which also has the degree of each vertex.
const walk_words = ({ by_degree }, { face_count, point_count }) =>
  Math.floor(face_count / 32) + 1 + (by_degree ? 2 * (2 * face_count + 1) + point_count : face_count + 1);
const all_walk_words = (groups, row) => groups.reduce((sum, group, g) => sum + (is_walked(groups, g) ? walk_words(group, row) : 0), 0);
// Of connectivity, walks and borders, one after the other.
const scratch_words = ({ symbol_count, events, groups }, row) =>
  Math.max((events.length > 0 ? 3 : 2) * (symbol_count + 1), all_walk_words(groups, row), 2 * row.point_count);
const point_words = ({ seams }, { face_count, point_count }) => (seams.length > 0 ? 4 * face_count + 2 * point_count : 0);
const cut_words = ({ seams }, { face_count, point_count }) => seams.length * (8 * face_count + point_count + kDataWords);
// Of a valence traversal: the symbols of its lists, and the valences of vertices.
const listed_words = ({ lists, symbol_count }) => (lists.length > 0 ? symbol_count : 0);
const valence_words = ({ lists, vertex_limit }) => (lists.length > 0 ? vertex_limit + 3 : 0);
// Of an attribute: the components of a value, the words of its values (which its symbols use first), the slots of the symbol table, and
// the bits of a bucket of that table.
const value_components = ({ coding, components }) => (coding === kCodingNormal ? 2 : components);
const value_room = (attribute, { point_count }) => point_count * value_components(attribute);
const slot_room = (values, { stream_bytes }) => Math.min(values, stream_bytes);
const bucket_bits = (values) => (values < 1024 ? 8 : 10);
function attribute_words(attribute, row) {
  if (attribute.coding === kCodingRaw) return kHeadWords;
  const values = value_room(attribute, row);
  return kHeadWords + 2 * values + 2 * slot_room(values, row) + 2 + (1 << bucket_bits(values));
}

/** The words of a stream's records in a batch: of lists in `plan`, of itself, of its attributes, and of its walk. */
export const record_words = ({ events, seams, lists, groups, attributes }, { point_count }, { runs, pairs }) => [
  3 * events.length + 4 * (1 + seams.length) + lists.length + lists.flat().length + kGroupWords * groups.length + runs.length + pairs.length,
  kStreamFields.length, kAttributeFields.length * attributes.length, point_count];

/** The words of memory that a stream takes. */
export function stream_words(head, row) {
  const { face_count, point_count, reference_count } = row;
  let words = 8 * face_count + 2 * (head.vertex_limit + 3) + scratch_words(head, row) + point_count + reference_count + 1 + point_words(head, row) +
    cut_words(head, row) + listed_words(head) + valence_words(head) + walk_count(head.groups) * (2 * point_count + 1);
  for (const attribute of head.attributes) words += attribute_words(attribute, row);
  return words;
}

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
  list_count = 0;  // the most of a stream, also below
  data_count = 0;
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
  #take(words) {
    return (this.#used += words) - words;
  }

  /**
   * Adds a stream.
   * @param {object} head of read_stream_head
   * @param {object} row counts of the directory
   * @param {{ runs: number[], pairs: number[], repeat_count: number }} references of read_stitch_map
   * @param {object} place what its container gives it: bytes_at, end, first_face, first_point, mesh_points, has_walk, first_stream, indices,
   *   grid_offset, and the stream_words
   * @param {object[]} outputs of its attributes: out, out_bytes, stride, is_grid, grid (of the first stream), bounds
   */
  add_stream(head, row, { runs, pairs, repeat_count }, place, outputs) {
    const { plan } = this, { symbol_count, vertex_limit, events, symbols, lists, start_faces, seams, groups, attributes, body } = head;
    const { face_count, point_count, reference_count } = row, { bytes_at, words } = place;
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

    const listed_bits = ([probability, at, size, state]) => plan.append([probability, at + bytes_at, size, state]);
    const events_at = plan.length;
    for (const event of events) plan.append(event);
    const start_at = listed_bits(start_faces), seams_at = plan.length;
    for (const bits of seams) listed_bits(bits);
    // Places of the lists, and of their symbols.
    const lists_at = lists.length > 0 ? plan.append(lists.map(() => 0)) : kNone, all = plan.length;
    for (const [count, precision, at, ...rest] of lists) plan.append([count, precision, at + bytes_at, ...rest]);
    lists.reduce((at, list, i) => (plan.set(lists_at + i, at), at + list.length), all);
    const opposite = this.#take(4 * face_count), vertex = this.#take(4 * face_count), border = this.#take(2 * (vertex_limit + 3)),
      scratch_count = scratch_words(head, row), scratch = this.#take(scratch_count), numbers = this.#take(point_count),
      references = this.#take(reference_count + 1), point_at = this.#take(point_words(head, row)), cut = this.#take(cut_words(head, row));
    const groups_at = plan.length, sequences = [];
    let walk = scratch;
    for (let g = 0; g < groups.length; ++g) {
      const { data, per_corner, by_degree, first, count } = groups[g], has_walk = is_walked(groups, g);
      sequences.push(has_walk ? this.#take(2 * point_count + 1) : sequences[walker(groups, g)]);
      plan.append([per_corner ? data + 1 : 0, first, count, sequences[g], has_walk ? walk : kNone, by_degree ? 1 : 0]);
      if (has_walk) walk += walk_words(groups[g], row);
    }
    // In the order of kStreamFields.
    this.streams.append([face_count, point_count, reference_count, symbol_count, vertex_limit, events_at, events.length, symbols + bytes_at,
      place.end, start_at, seams_at, seams.length, body + bytes_at, groups_at, groups.length, this.attributes.length / kAttributeFields.length,
      attributes.length, opposite, vertex, border, scratch, scratch_count, numbers, references, point_at, cut, place.first_face, place.first_point,
      place.mesh_points, place.has_walk, this.walk_words, plan.append(runs), runs.length / kRunWords, plan.append(pairs), pairs.length / kPairWords,
      repeat_count, place.first_stream, place.indices, lists_at, this.#take(listed_words(head)), this.#take(valence_words(head))]);
    this.walk_words += point_count;
    const position = attributes.findIndex(({ semantic }) => semantic === 0);
    for (let i = 0; i < attributes.length; ++i)
      this.#add_attribute(attributes[i], row, position >= 0 && position < i ? position + 1 : 0, outputs[i], place.grid_offset);
  }
  #add_attribute(attribute, row, position, { out, out_bytes, stride, is_grid, grid, bounds }, grid_offset) {
    const { group, coding, components, type_bytes } = attribute, values = coding === kCodingRaw ? 0 : value_room(attribute, row);
    const slots = slot_room(values, row), bits = bucket_bits(values), room = (words) => (coding === kCodingRaw ? 0 : this.#take(words));
    // In the order of kAttributeFields.
    this.attributes.append([group, coding, components, value_components(attribute), type_bytes, position, this.#take(kHeadWords), room(values),
      room(values), values, room(2 * slots + 2), slots, room(1 << bits), bits, out, out_bytes, stride, is_grid, grid + (out === kNone ? 0 : grid_offset), bounds]);
  }
}
