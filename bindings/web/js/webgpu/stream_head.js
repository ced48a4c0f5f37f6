// The parts of a Draco stream whose places are stored: everything before the entropy-coded values of its attributes. Draco bitstream
// specification 2.2; the checks are those of src/core (draco_header.h, edgebreaker_decoder.h, rans.h, attributes.h).
import { is_justified_stream } from './directory.js';
import { refuse } from './refusal.js';

export const kCodingRaw = 0, kCodingInteger = 1, kCodingQuantized = 2, kCodingNormal = 3;
const kTypeBytes = [0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1], kFloat32 = 9, kUint32 = 6;

/** Reads bytes of a container; all that ends early is refused. */
export class Reader {
  at = 0;
  end = 0;

  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }
  u8() {
    if (this.at >= this.end) refuse('a stream that ends early');
    return this.bytes[this.at++];
  }
  #leb128(most_bytes) {
    for (let i = 0, value = 0; i < most_bytes; ++i) {
      const byte = this.u8();
      value += i < 4 ? (byte & 127) << (7 * i) : (byte & 127) * 128 ** i;
      if (byte < 128) return value;
    }
    return refuse('a number that is too long');
  }
  varint() {
    return this.#leb128(5) % 2 ** 32;
  }
  varint64() {
    return this.#leb128(10);
  }
  skip(count) {
    if (count > this.end - this.at) refuse('a stream that ends early');
    this.at += count;
  }
}

// Bits of one probability: [probability of 1, place of the block, its bytes before the state, the state].
function read_bits(reader) {
  const kBase = 4096, { bytes, at } = reader;
  let length = bytes[at + 1], begin = at + 2;
  if (begin > reader.end || length > 127) {
    reader.skip(1);
    length = reader.varint();
    begin = reader.at;
  }
  const end = begin + length;
  if (end > reader.end) refuse('a stream that ends early');
  if (length === 0) refuse('a broken block of bits');
  reader.at = end;
  const count = 1 + (bytes[end - 1] >> 6);
  if (count > 3 || count > length) refuse('a broken block of bits');
  let state = bytes[end - 1] & 63;
  for (let i = 2; i <= count; ++i) state = (state << 8) | bytes[end - i];
  state += kBase;
  if (state >= 256 * kBase) refuse('a broken block of bits');
  return [(256 - bytes[at]) & 255, begin, length - count, state];
}

// The lists of symbols of a valence traversal, in the order of valences: [count, bits of precision, place of the block, its bytes before the
// state, the state, slots...], with two words for each symbol that occurs, itself and its first number, and two more for the end. Tagged
// lists have no stored end, and are hardly ever written.
function read_symbol_lists(reader, symbol_count) {
  const kLists = 6, kRaw = 1, kMostBits = 18, kMostSlots = 64, lists = [];
  let left = symbol_count;
  for (let i = 0; i < kLists; ++i) {
    const count = reader.varint();
    if ((left -= count) < 0) refuse('too many symbols');
    if (count === 0) {
      lists.push([0, 0, 0, 0, 0]);
      continue;
    }
    if (reader.u8() !== kRaw) refuse('tagged lists of symbols');
    const bits = reader.u8(), slots = [];
    if (bits === 0 || bits > kMostBits) refuse('a broken table');
    const precision = Math.min(Math.max(Math.floor((3 * bits) / 2), 12), 20), total = 2 ** precision, table = reader.varint();
    let sum = 0;
    for (let symbol = 0; symbol < table; ++symbol) {
      const byte = reader.u8(), extra_bytes = byte % 4;
      if (extra_bytes === 3) {  // this and some more do not occur
        symbol += byte >> 2;
        if (symbol >= table) refuse('a broken table');
        continue;
      }
      let probability = byte >> 2;
      for (let k = 0; k < extra_bytes; ++k) probability += reader.u8() * 2 ** (8 * k + 6);
      if (probability === 0) continue;
      slots.push(symbol, sum);
      if ((sum += probability) > total || slots.length > 2 * kMostSlots) refuse('a broken table');
    }
    if (sum !== total) refuse('a broken table');
    const length = reader.varint64(), { at, bytes } = reader;
    reader.skip(length);
    if (length === 0) refuse('a broken block of symbols');
    const state_bytes = 1 + (bytes[at + length - 1] >> 6);
    if (state_bytes > length) refuse('a broken block of symbols');
    let value = 0;
    for (let k = 1; k <= state_bytes; ++k) value = value * 256 + bytes[at + length - k];
    const state = (value % 2 ** (8 * state_bytes - 2)) + 4 * total;
    if (state >= 1024 * total) refuse('a broken block of symbols');
    lists.push([count, precision, at, length - state_bytes, state, ...slots, 0, sum]);
  }
  return lists;
}

// Split events: [source, split, whether it is the right edge], in order of the stream.
const kNone = [];
export function split_event(symbol_count, source, back) {
  if (source >= symbol_count || back > source) refuse('a broken split event');
  return [symbol_count - 1 - source, symbol_count - 1 - source + back, 0];
}
function read_split_events(reader, count, symbol_count) {
  const events = [];
  for (let i = 0, source = 0; i < count; ++i) {
    source += reader.varint();
    events.push(split_event(symbol_count, source, reader.varint()));
  }
  for (let i = 0; i < count; ++i) events[i][2] = (reader.bytes[reader.at + (i >> 3)] >> (i & 7)) & 1;
  reader.skip((count + 7) >> 3);
  return events;
}

export function read_groups(reader, data_count) {
  const kMostGroups = 129, count = reader.u8();
  if (count > kMostGroups) refuse('too many groups of attributes');
  let has_shared = false;
  const groups = Array.from({ length: count }, () => {
    const data = (reader.u8() << 24) >> 24, per_corner = reader.u8() !== 0, traversal = reader.u8();
    if (traversal > 1 || (per_corner && traversal === 1)) refuse('an unknown traversal');
    if (data < 0 ? per_corner || has_shared : data >= data_count) refuse('a broken group of attributes');
    has_shared ||= data < 0;
    return { data, per_corner, by_degree: traversal === 1, first: 0, count: 0 };
  });
  const seen = groups.map(({ data }) => data).filter((data) => data >= 0);
  if (new Set(seen).size < seen.length) refuse('a broken group of attributes');
  return groups;
}

export function read_attributes(reader, groups) {
  const kMostAttributes = 256, kSemantics = 5, kTypes = 11, attributes = [];
  for (const [g, group] of groups.entries()) {
    group.first = attributes.length;
    group.count = reader.varint();
    if (group.count === 0 || group.count + attributes.length > kMostAttributes) refuse('a broken group of attributes');
    for (let i = 0; i < group.count; ++i) {
      const semantic = reader.u8(), type = reader.u8(), components = reader.u8(), normalized = reader.u8() !== 0, unique_id = reader.varint();
      if (semantic >= kSemantics || type === 0 || type > kTypes || components === 0) refuse('a broken attribute');
      attributes.push({ group: g, semantic, type, components, normalized, unique_id, coding: 0, type_bytes: kTypeBytes[type] });
    }
    for (let i = group.first; i < attributes.length; ++i) {
      const attribute = attributes[i], coding = (attribute.coding = reader.u8()), is_float = attribute.type === kFloat32;
      if (coding > kCodingNormal || (coding === kCodingQuantized && !is_float) ||
        (coding === kCodingNormal && (!is_float || attribute.components !== 3)) ||
        (coding === kCodingInteger && attribute.type > kUint32)) refuse('a broken attribute');
    }
  }
  return attributes;
}

// The group whose walk a group has: groups that have the mesh's table share one for each kind of walk.
const walker = (groups, g) => (groups[g].per_corner ? g : groups.findIndex(({ per_corner, by_degree }) => !per_corner && by_degree === groups[g].by_degree));

/** The components of an attribute's values, as they are decoded. */
export const value_components = ({ coding, components }) => (coding === kCodingNormal ? 2 : components);

/** What the layout needs of groups and attributes. It is made once for all streams that have them. */
export class Shape {
  walks = 0;         // of faces, also below
  degree_walks = 0;  // by prediction degree
  walkers;           // by group
  value_components;  // by attribute, of a value; 0 if values are stored as they are
  positions;         // by attribute: one more than the number of the positions before it

  constructor(groups, attributes) {
    this.walkers = groups.map((_, g) => (g === 0 ? 0 : walker(groups, g)));
    groups.forEach(({ by_degree }, g) => {
      if (this.walkers[g] !== g) return;
      if (by_degree) ++this.degree_walks;
      else ++this.walks;
    });
    this.value_components = attributes.map((attribute) => (attribute.coding === kCodingRaw ? 0 : value_components(attribute)));
    const first = attributes.findIndex(({ semantic }) => semantic === 0);
    this.positions = attributes.map((_, i) => (first >= 0 && i > first ? first + 1 : 0));
  }
}

// Whether bytes at two places are the same: words first.
function are_same(view, a, b, length) {
  let i = 0;
  for (; i + 4 <= length; i += 4) if (view.getInt32(a + i) !== view.getInt32(b + i)) return false;
  for (; i < length; ++i) if (view.getUint8(a + i) !== view.getUint8(b + i)) return false;
  return true;
}

// Streams of one container mostly have the same groups and attributes, which are then read once.
function read_descriptions(reader, data_count, last) {
  if (last !== undefined && last.seams.length === data_count) {
    const { at } = reader, begin = last.groups_at, length = last.body - begin;
    if (length <= reader.end - at && are_same(reader.view, at, begin, length)) {
      reader.at = at + length;
      return last;
    }
  }
  const groups = read_groups(reader, data_count), attributes = read_attributes(reader, groups);
  return { groups, attributes, shape: new Shape(groups, attributes) };
}

/** Refuses counts that libdraco refuses, or that the bytes of a stream do not justify. */
export function check_counts(vertex_count, faces, data_count, symbol_count, split_symbol_count, split_count, stream_bytes) {
  const kMostData = 127;
  if (vertex_count > 3 * faces || symbol_count > faces || faces > symbol_count + Math.floor(symbol_count / 3) || split_symbol_count > symbol_count ||
    split_count > faces || vertex_count * (vertex_count - 1) < 2 * Math.floor((3 * faces) / 2) || data_count > kMostData ||
    !is_justified_stream(faces + vertex_count + split_symbol_count, stream_bytes)) refuse(kContradiction);
}

const kContradiction = 'counts that contradict each other';
// "DRACO", and the version. Then come the kind, a mesh, and the method, Edgebreaker.
const kDraco = [0x44524143, 0x4f020201], kFrontBytes = 12;
// Of vertices, faces, attribute data (a byte; the others are varints), symbols, split symbols, split events.
const kCounts = 6, kDataCount = 2, counts = new Uint32Array(kCounts);

/**
 * The head of the stream in bytes [begin, end), with `face_count` faces. There are thousands, which V8 at first interprets: so this makes
 * and calls little.
 * @param {Reader} reader of the container
 * @param {object} [last] the head of the stream before it
 */
export function read_stream_head(reader, begin, end, face_count, last) {
  const { bytes, view } = reader, kEdgebreaker = 1, kValence = 2;
  if (end - begin < kFrontBytes || view.getInt32(begin) !== kDraco[0] || view.getInt32(begin + 4) !== kDraco[1]) refuse('not a Draco mesh of version 2.2');
  if (bytes[begin + 8] !== kEdgebreaker) refuse('a sequential stream');
  if (bytes[begin + 10] > 127) refuse('metadata');
  const traversal = bytes[begin + 11];
  if (traversal !== 0 && traversal !== kValence) refuse('an unknown traversal');
  reader.at = begin + kFrontBytes;
  reader.end = end;
  for (let k = 0; k < kCounts; ++k) {
    const at = reader.at, low = bytes[at], high = bytes[at + 1];
    if (low < 128 || k === kDataCount) counts[k] = low, (reader.at = at + 1);
    else if (high < 128) counts[k] = low - 128 + (high << 7), (reader.at = at + 2);
    else counts[k] = reader.varint();
  }
  if (reader.at > end) refuse('a stream that ends early');
  const vertex_count = counts[0], faces = counts[1], data_count = counts[2], symbol_count = counts[3], split_symbol_count = counts[4], split_count = counts[5];
  const vertex_limit = vertex_count + split_symbol_count;
  if (faces !== face_count) refuse(kContradiction);
  check_counts(vertex_count, faces, data_count, symbol_count, split_symbol_count, split_count, end - begin);
  const events = split_count > 0 ? read_split_events(reader, split_count, symbol_count) : kNone, symbol_bytes = traversal === kValence ? 0 : reader.varint64(), symbols = reader.at;
  reader.skip(symbol_bytes);
  const start_faces = read_bits(reader), seams = data_count > 0 ? Array.from({ length: data_count }, () => read_bits(reader)) : kNone;
  const lists = traversal === kValence ? read_symbol_lists(reader, symbol_count) : kNone;
  const groups_at = reader.at, { groups, attributes, shape } = read_descriptions(reader, data_count, last);
  // The plan sets other counts of the directory, and stream_words the scratch_count.
  return { symbol_count, vertex_limit, events, symbols, lists, start_faces, seams, groups, attributes, shape, groups_at, body: reader.at,
    face_count, point_count: 0, reference_count: 0, scratch_count: 0, stream_bytes: end - begin };
}
