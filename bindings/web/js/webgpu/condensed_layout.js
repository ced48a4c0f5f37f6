// The records that condensed streams have in `plan`, beside the records of layout.js: of streams, of their attribute data, and of attributes.
import { kNoTable, kSchemeCreated, kSchemeRaw } from './condensed_head.js';
import { add_record_words, constants, kAttributeFields, kGroupWords, kNone, kStreamFields, Layout, schemes, stream_words } from './layout.js';
import { value_components } from './stream_head.js';

// `end` of a stream is that of its first section. Places in memory: own values of the border, and the coder after connectivity and seams.
const kRecordFields = ['kContexts', 'kContextCount', 'kFirstSection', 'kNumbersEnd', 'kComponents', 'kSplits', 'kHasBorders', 'kBorderCount', 'kBorderWidth',
  'kFirstTable', 'kOtherTable', 'kOwnValues', 'kKnown', 'kMostPlaces', 'kCoder'];
// The probabilities of a seam after none and after one.
const kDataFields = ['kHasBits', 'kAfterNone', 'kAfterSeam'];
// An order of creation has one of its attributes' records as its own: `kOrder` is its place in memory.
const kModelFields = ['kByCreation', 'kIsOrderOwner', 'kOrder', 'kBackward', 'kHasKnown', 'kTwo', 'kMean', 'kReach', 'kPredictors', 'kPredictorWords',
  'kBegin', 'kEnd', 'kStoredScheme', 'kStoredTransform', 'kStoredLow', 'kStoredHigh', 'kHasGrid', 'kStoredBits', 'kRange', 'kOrientation', 'kFlip', 'kFlags'];
// Behind them: three tables, four counts of flags and their probabilities, and the origin.
const kTables = kModelFields.length, kFlagCounts = kTables + 3, kCreaseOf = kFlagCounts + 4, kOriginOf = kCreaseOf + 4;
const numbered = (names) => Object.fromEntries(names.map((name, i) => [`${name}Field`, i]));
const kRecordWords = kRecordFields.length, kDataWords = kDataFields.length;

/** The records in WGSL: names end in Field. */
export const condensed_records = constants({ ...numbered(kRecordFields), ...numbered(kDataFields), ...numbered(kModelFields), kDataOfField: kRecordWords, kDataWordsField: kDataWords,
  kTablesField: kTables, kFlagCountsField: kFlagCounts, kCreasesField: kCreaseOf, kOriginField: kOriginOf, kSchemeCreated, kSchemeRaw });

const bits_words = (count) => Math.max(Math.ceil(count / 32), 1);
const seam_words = ({ condensed: { has_seams }, face_count }) => has_seams.reduce((sum, has) => sum + (has ? bits_words(2 * face_count) : 0), 0);
const most_places = ({ condensed: { tables, border_count }, reference_count }) => (tables.has_borders ? border_count + reference_count : 0);
const border_width = ({ attributes: [first] }) => value_components(first);
// A flag for each normal, or four lists of them.
const flag_words = ({ scheme, flags }, { point_count }) =>
  (scheme === schemes.kSchemeGeometricNormal ? [point_count] : flags).reduce((sum, count) => sum + bits_words(count), 0);
/** What the CPU takes for the values at a stream's border, and the numbers of each. */
export function shared_bytes(head) {
  const width = border_width(head);
  return { bytes: most_places(head) * (4 * width + 1), width };
}
const kCoderWords = 3;
// The number of parallelograms, and their vertices: of one or of two.
const predictor_words = ({ two, mean, reach }) => (two || mean || reach > 0 ? 7 : 4);

// The attribute whose order of creation an attribute has: tables of the mesh have one for each direction.
function order_owner({ groups, attributes, condensed }, i) {
  const { stored, tables } = condensed, first = new Map();
  condensed.owners ??= stored.map(({ by_creation }, k) => {
    if (!by_creation) return -1;
    const { group } = attributes[k], order = `${groups[group].per_corner ? group : -1} ${tables.models[k].backward} ${k === 0 && tables.has_borders}`;
    if (!first.has(order)) first.set(order, k);
    return first.get(order);
  });
  return condensed.owners[i];
}
const order_words = ({ point_count }) => 2 * point_count + 2;
// What an attribute takes besides its words in layout.js.
function more_words(head, i) {
  const { stored, tables } = head.condensed, words = flag_words(stored[i], head);
  if (!stored[i].by_creation) return words;
  return words + predictor_words(tables.models[i]) * head.point_count + (order_owner(head, i) === i ? order_words(head) : 0);
}

/** The words of memory that a stream takes. */
export function condensed_stream_words(head) {
  let words = stream_words(head) + kCoderWords + head.condensed.border_count * border_width(head) + seam_words(head);
  for (let i = 0; i < head.attributes.length; ++i) words += more_words(head, i);
  return words;
}
/** See add_record_words. */
export function add_condensed_record_words(sizes, head) {
  add_record_words(sizes, head);
  const { attributes, condensed } = head;
  sizes[0] += kRecordWords + kDataWords * condensed.has_seams.length + condensed.starts.length;
  for (const { origin } of attributes) sizes[0] += kOriginOf + origin.length;
  sizes[3] += most_places(head) * (1 + border_width(head));
}

export class CondensedLayout extends Layout {
  #tables_at = 0;  // of the container
  #head;
  #orders = [];    // by attribute: places in memory
  #bytes_at = 0;

  add_stream(head, words, place, outputs, stream, directory) {
    const { condensed } = head, { tables, stored, starts, has_seams } = condensed, { plan } = this, { bytes_at } = place;
    if (stream === 0) this.#tables_at = plan.append(tables.words);
    this.#head = head;
    this.#orders = [];
    this.#bytes_at = bytes_at;
    const record = plan.more(kRecordWords + kDataWords * has_seams.length), starts_at = plan.append(starts), walk_words = this.walk_words;
    // Bits: where they are (constant, in `plan` or in memory), their place, and the number of their words.
    const kConstant = 0, kInPlan = 1, kInMemory = 2;
    super.add_stream({ ...head, symbols: record - bytes_at }, words, place, outputs, stream, directory);
    const w = plan.words, s = this.streams.words, at = this.streams.length - kStreamFields.length, field = (name) => s[at + kStreamFields.indexOf(name)];
    w.set(condensed.has_start_bits ? [kInPlan, starts_at, starts.length] : [kConstant, starts[0] & 1, 1], field('start_faces'));
    for (const [d, has] of has_seams.entries()) {
      const size = bits_words(2 * head.face_count);
      w.set(has ? [kInMemory, this.take(size), size] : [kConstant, 0, 1], field('seams') + 4 * d);
      w.set([has ? 1 : 0, ...tables.seams[d]], record + kRecordWords + kDataWords * d);
    }
    // Walks that nothing needs are not made.
    for (let g = 0; g < head.groups.length; ++g) {
      const place_of = (group) => field('groups') + kGroupWords * group, sequence_of = (group) => w[place_of(group) + 3];
      if (head.attributes.every(({ group }, i) => stored[i].by_creation || sequence_of(group) !== sequence_of(g))) w[place_of(g) + 4] = kNone;
    }
    const own_values = this.take(condensed.border_count * border_width(head)), places = most_places(head);
    this.walk_words += places * (1 + border_width(head));
    w.set([this.#tables_at, tables.contexts.count, stored[0].begin + bytes_at, condensed.numbers_end, condensed.component_count, condensed.split_symbol_count,
      tables.has_borders ? 1 : 0, condensed.border_count, border_width(head), ...tables.border_tables.map((table) => this.#table(table)), own_values,
      walk_words + head.point_count, places, this.take(kCoderWords)], record);
  }
  #table(at) {
    return at === kNoTable ? kNone : this.#tables_at + at;
  }

  add_attribute(attribute, head, position, output, grid_offset) {
    super.add_attribute(attribute, head, position, output, grid_offset);
    const i = this.#orders.length, { condensed, point_count } = this.#head, { tables, has_grid } = condensed, one = condensed.stored[i], model = tables.models[i];
    const owner = order_owner(this.#head, i);
    this.#orders.push(owner === i ? this.take(order_words(this.#head)) : owner < 0 ? 0 : this.#orders[owner]);
    const predictors = one.by_creation ? this.take(predictor_words(model) * point_count) : 0, flags = this.take(flag_words(one, this.#head));
    const record = this.plan.append([one.by_creation, owner === i, this.#orders[i], model.backward, i === 0 && tables.has_borders, model.two, model.mean, model.reach,
      predictors, predictor_words(model), one.begin + this.#bytes_at, one.end + this.#bytes_at, one.scheme, one.transform, one.low, one.high,
      has_grid[i], attribute.bits, attribute.range, model.orientations, model.flips, flags,
      ...one.tables.map((table) => this.#table(table)), ...one.flags, ...model.creases, ...attribute.origin]);
    this.attributes.words[this.attributes.length - kAttributeFields.length + kAttributeFields.indexOf('slots')] = record;
  }
}
