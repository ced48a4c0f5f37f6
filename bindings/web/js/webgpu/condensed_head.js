// The head of a container of condensed streams (src/container/condensed_head.h): what its streams have in common. All checks are those of
// src/container: what breaks a rule is refused.
import { BitString, NumberKind } from './bit_string.js';
import { schemes } from './layout.js';
import { refuse } from './refusal.js';
import { kCodingInteger, kCodingNormal, kCodingQuantized, kCodingRaw, read_attributes, read_groups, Reader, Shape, value_components } from './stream_head.js';

const { kStoredNone, kSchemeNone, kSchemeDifference, kSchemeParallelogram, kSchemeParallelograms, kSchemeTexCoords, kSchemeGeometricNormal, kTransformWrap,
  kTransformCanonicalized } = schemes;
/** In place of a scheme: values are raw, or in order of creation. */
export const kSchemeRaw = 251, kSchemeCreated = 250;
const kSlots = 4096, kSlotBits = 12, kMostTokens = 116, kBucketBits = 6;
export const kNoTable = 0xffffffff;

/** What streams share, as their heads need it; `words` are for the device. */
class TablesReader {
  words = [];
  #bits;
  #count;
  #used;

  /** Each section begins anew. */
  begin(bytes, [begin, end]) {
    this.#count = new NumberKind(0);
    this.#used = new NumberKind(5);
    this.#bits = new BitString(bytes, begin, end);
  }
  end() {
    this.#bits.finish();
  }
  #number_from_one() {
    return this.#bits.number(this.#count) + 1;
  }
  #probability() {
    return this.#bits.bits(kSlotBits) || refuse('a probability of 0');
  }

  skeletons() {
    const kMostSkeletons = 255, kMostBytes = 4096, kMostLevel = 11, of_length = new NumberKind(5), count = this.#number_from_one();
    if (count > kMostSkeletons) refuse('too many skeletons');
    return Array.from({ length: count }, () => {
      const level = this.#bits.bits(4), length = this.#bits.number(of_length);
      if (level > kMostLevel || length > kMostBytes) refuse('a broken skeleton');
      return read_skeleton(Uint8Array.from({ length }, () => this.#bits.bits(8)));
    });
  }

  // Two words for each context: the first numbers of S and L, R and E, and whether the context is used, in the highest bit.
  contexts() {
    const kMostHistory = 5, kValences = 8, kOfValences = 30, kSymbols = 5, coding = this.#bits.bits(4), has_valences = coding === kValences;
    if (coding > kMostHistory && !has_valences) refuse('unknown contexts of symbols');
    const count = has_valences ? kOfValences : kSymbols ** coding, of_frequency = new NumberKind(4);
    for (let i = 0; i < count; ++i) {
      const firsts = [0];
      for (let s = 0; s < kSymbols; ++s) firsts.push(firsts[s] + this.#bits.number(of_frequency));
      const sum = firsts[kSymbols];
      if (sum !== 0 && sum !== kSlots) refuse('a broken context of symbols');
      if (sum === 0) this.words.push(0, 0);
      else this.words.push((firsts[1] | (firsts[2] << 16) | (1 << 31)) >>> 0, firsts[3] | (firsts[4] << 16));
    }
    return { has_valences, count };
  }

  // Returns the place of the table in `words`: for the highest bits of a slot the number of a token, tokens with their first slots, and one
  // more with the end of all.
  token_table() {
    const used = this.#bits.number(this.#used), of_frequency = new NumberKind(4), slots = [];
    if (used > kMostTokens) refuse('a table of too many tokens');
    if (used === 0) return kNoTable;
    let sum = 0;
    for (let token = 0; token < used; ++token) {
      const frequency = this.#bits.number(of_frequency);
      if (frequency > 0) slots.push((sum << 8) | token);
      if ((sum += frequency) > kSlots) refuse('a broken table');
    }
    if (sum !== kSlots) refuse('a broken table');
    slots.push(kSlots << 8);
    const at = this.words.length;
    for (let bucket = 0, slot = 0; bucket < 1 << kBucketBits; ++bucket) {
      while (slots[slot + 1] >> 8 <= bucket << (kSlotBits - kBucketBits)) ++slot;
      this.words.push(slot);
    }
    this.words.push(...slots);
    return at;
  }

  attributes() {
    const kMostAttributes = 256, kMostSets = 8, kMostSetsOfAll = 256, kMostReach = 2, count = this.#number_from_one();
    if (count > kMostAttributes) refuse('too many models');
    let set_sum = 0;
    return Array.from({ length: count }, () => {
      const bits = this.#bits, model = { by_creation: bits.flag(), backward: false, two: false, mean: false, reach: 0, sets: [], creases: [0, 0, 0, 0], orientations: 0, flips: 0 };
      if (model.by_creation) {
        model.backward = bits.flag(), model.two = bits.flag(), model.mean = bits.flag();
        model.reach = bits.bits(2);
        if (model.reach > kMostReach) refuse('an unknown reach');
      }
      const sets = this.#number_from_one();
      if (sets > kMostSets || (set_sum += sets) > kMostSetsOfAll) refuse('too many sets of tables');
      for (let s = 0; s < sets; ++s) {
        const set = [this.token_table(), this.token_table()];
        set.push(model.by_creation ? this.token_table() : kNoTable);
        model.sets.push(set);
      }
      model.has_flags = bits.flag();
      if (model.has_flags) {
        model.creases = model.creases.map(() => this.#probability());
        model.orientations = this.#probability();
        model.flips = this.#probability();
      }
      return model;
    });
  }
  seams() {
    const kMostData = 128, count = this.#bits.number(this.#count);
    if (count > kMostData) refuse('too many models of seams');
    return Array.from({ length: count }, () => [this.#probability(), this.#probability()]);
  }
}

// What a skeleton says: the literal bytes of a Draco stream, without counts, symbols and values. Raw values are integers here.
function read_skeleton(bytes) {
  const reader = new Reader(bytes);
  reader.end = bytes.length;
  if (reader.u8() + 256 * reader.u8() >= 0x8000) refuse('metadata');
  const traversal = reader.u8(), kValence = 2;
  if (traversal !== 0 && traversal !== kValence) refuse('an unknown traversal');
  const data_count = reader.u8(), groups = read_groups(reader, data_count), attributes = read_attributes(reader, groups);
  if (attributes.length === 0) refuse('no attributes');
  for (const { first, count } of groups) {
    const of_group = attributes.slice(first, first + count);
    for (const attribute of of_group) {
      attribute.is_raw = attribute.coding === kCodingRaw;
      if (!attribute.is_raw) read_scheme(reader, attribute, attributes);
      else if (attribute.type_bytes > 4) refuse('raw values of 64 bits');
      else attribute.coding = kCodingInteger;
    }
    for (const attribute of of_group) read_transform(reader, attribute);
  }
  for (const attribute of attributes) if (attribute.is_raw) attribute.scheme = kSchemeRaw;
  return { data_count, groups, attributes, shape: new Shape(groups, attributes) };
}

const word = (reader) => (reader.u8() | (reader.u8() << 8) | (reader.u8() << 16) | (reader.u8() << 24)) >>> 0;
// What libdraco reads otherwise than an encoder means is refused.
function read_scheme(reader, attribute, all) {
  const stored = reader.u8(), is_wrap = attribute.coding !== kCodingNormal;
  attribute.scheme = stored === kStoredNone ? kSchemeNone : stored;
  attribute.transform = kTransformWrap;
  attribute.most = 0;
  if (stored !== kStoredNone) {
    attribute.transform = reader.u8();
    if (is_wrap !== (attribute.transform === kTransformWrap) || attribute.transform < kTransformWrap || attribute.transform > kTransformCanonicalized)
      refuse('an unknown transform');
    if (stored !== kSchemeDifference && !(is_wrap && (stored === kSchemeParallelogram || stored === kSchemeParallelograms))) {
      const position = all.slice(0, all.indexOf(attribute)).find(({ semantic }) => semantic === 0);
      if (stored !== (is_wrap ? kSchemeTexCoords : kSchemeGeometricNormal) || value_components(attribute) !== 2 || position === undefined ||
        position.is_raw || value_components(position) !== 3) refuse('an unknown prediction');
    }
  }
  if (reader.u8() === 0) refuse('values without entropy coding');
  if (stored === kStoredNone || is_wrap) return;
  const most = word(reader);
  if (attribute.transform === kTransformCanonicalized) reader.skip(4);
  let bits = 0;
  while (bits < 31 && 2 ** bits - 1 < most) ++bits;
  if (bits < 2 || bits > 30 || most % 2 === 0) refuse('a broken grid');
  attribute.most = 2 ** bits - 1;
}
const is_finite = (bits) => (bits & 0x7f800000) !== 0x7f800000;
function read_transform(reader, attribute) {
  attribute.origin = [];
  attribute.bits = attribute.range = 0;
  if (attribute.coding === kCodingQuantized) {
    attribute.origin = Array.from({ length: attribute.components }, () => word(reader));
    attribute.range = word(reader);
    attribute.bits = reader.u8();
    if (attribute.bits < 1 || attribute.bits > 30 || ![attribute.range, ...attribute.origin].every(is_finite)) refuse('a broken range');
  } else if (attribute.coding === kCodingNormal) {
    attribute.bits = reader.u8();
    if (attribute.bits < 2 || attribute.bits > 30) refuse('a broken grid');
  }
}

/** The tables of a container, and which skeleton each of its streams has. */
export class CondensedTables {
  skeleton_of = [];  // by stream
  #skeleton_count = 0;
  #of_skeleton = new NumberKind(0);

  /** @param {Uint8Array} bytes of the container @param {Map<number, number[]>} sections of its head */
  constructor(bytes, sections) {
    const kTables = 1, kBorders = 2, kDeltas = 3, kResidue = 1;
    if (bytes[5] === kResidue) refuse('a residue');
    if (sections.has(kDeltas)) refuse('condensed morph targets');
    for (const type of sections.keys()) if (type !== kTables && type !== kBorders) refuse('an unknown section of the head');
    const reader = new TablesReader();
    reader.begin(bytes, sections.get(kTables) ?? refuse('a broken head'));
    this.skeletons = reader.skeletons();
    this.contexts = reader.contexts();
    this.models = reader.attributes();
    this.seams = reader.seams();
    reader.end();
    this.has_borders = sections.has(kBorders);
    this.border_tables = [kNoTable, kNoTable];
    if (this.has_borders) {
      reader.begin(bytes, sections.get(kBorders));
      this.border_tables = [reader.token_table(), reader.token_table()];
      reader.end();
    }
    this.words = Uint32Array.from(reader.words);
  }

  /** The directory's own part: how many skeletons it names, and by row which one. @param {BitString} bits */
  begin_rows(bits, skeletons) {
    if (skeletons === 0 || skeletons > this.skeletons.length) refuse('a broken directory');
    this.#skeleton_count = skeletons;
    if (bits.flag()) refuse('stored patches beside condensed ones');
  }
  next_row(bits) {
    const skeleton = this.#skeleton_count > 1 ? bits.number(this.#of_skeleton) : 0;
    if (skeleton >= this.#skeleton_count) refuse('a broken directory');
    this.skeleton_of.push(skeleton);
  }
}
