// The head of a condensed stream (src/core/condensed/condensed_header.h): the counts of its directory and its skeleton, and the numbers of
// its first section, plain bits from its last byte on.
import { BitString, floor_log2, NumberKind } from './bit_string.js';
import { kSchemeCreated, kSchemeRaw } from './condensed_head.js';
import { schemes } from './layout.js';
import { refuse } from './refusal.js';
import { check_counts, kCodingNormal, split_event } from './stream_head.js';

const { kSchemeNone, kSchemeDifference, kSchemeParallelogram, kSchemeParallelograms, kSchemeTexCoords, kSchemeGeometricNormal, kTransformWrap } = schemes;

const kLeastSection = 4;  // the state of its coder
const is_by_creation = ({ scheme }, model) => model.by_creation && [kSchemeNone, kSchemeDifference, kSchemeParallelogram].includes(scheme);
const flag_lists = ({ scheme }) => (scheme === kSchemeParallelograms ? 4 : scheme === kSchemeTexCoords ? 1 : 0);

// Reads the numbers of attributes: where each has its section, and how its values are stored.
function read_attribute_numbers(bits, tables, begin, face_count, stored) {
  const of_bytes = new NumberKind(8), of_low = new NumberKind(12), of_extent = new NumberKind(12), of_flags = new NumberKind(8);
  let at = begin;
  for (let i = 1; i < stored.length; ++i) {
    const size = bits.number(of_bytes);
    if (size < kLeastSection) refuse('a broken section');
    stored[i].begin = at;
    stored[i].end = at += size;
  }
  for (const one of stored) {
    if (one.by_creation || one.scheme === kSchemeNone || one.scheme === kSchemeRaw || one.transform !== kTransformWrap) continue;
    one.low = bits.signed(of_low);
    one.high = one.low + bits.number(of_extent);
    if (one.low < -(2 ** 31) || one.high >= 2 ** 31 || one.high - one.low >= 0x7fffffff) refuse('a broken range of values');
  }
  for (const [i, one] of stored.entries()) {
    const lists = flag_lists(one);
    for (let k = 0; k < lists; ++k) if ((one.flags[k] = bits.number(of_flags)) > 3 * face_count) refuse('too many flags');
    if ((one.scheme === kSchemeGeometricNormal || one.flags.some((count) => count > 0)) && !tables.models[i].has_flags) refuse('flags without a model');
  }
  for (const [i, one] of stored.entries()) {
    const { sets } = tables.models[i], set = sets.length > 1 ? bits.bits(floor_log2(sets.length - 1) + 1) : 0;
    one.tables = sets[set] ?? refuse('an unknown set of tables');
  }
  stored[0].begin = at;
}

/**
 * @param {import('./stream_head.js').Reader} reader of the container
 * @param {{ tables: import('./condensed_head.js').CondensedTables, stream_at: Uint32Array, faces: Uint32Array, points: Uint32Array }} directory
 * @param {number} stream
 */
export function read_condensed_stream({ bytes }, { tables, stream_at, faces, points }, stream) {
  const begin = stream_at[stream], end = stream_at[stream + 1], face_count = faces[stream], point_count = points[stream];
  const { data_count, groups, attributes, shape } = tables.skeletons[tables.skeleton_of[stream]];
  if (attributes.length > tables.models.length || data_count > tables.seams.length) refuse('attributes without a model');
  const stored = attributes.map((attribute, i) => ({ scheme: attribute.scheme, transform: attribute.transform ?? kTransformWrap, begin: 0, end, low: 0,
    high: attribute.most ?? 0, flags: [0, 0, 0, 0], tables: null, by_creation: !attribute.is_raw && is_by_creation(attribute, tables.models[i]) }));

  const bits = new BitString(new Uint8Array(bytes.subarray(begin, end)).reverse(), 0, end - begin), of_count = new NumberKind(0), of_event = new NumberKind(8);
  const interior_count = bits.number(of_count), vertex_count = point_count - bits.signed(new NumberKind(0)), split_symbol_count = bits.number(new NumberKind(2)),
    component_count = bits.number(of_count) + 1, symbol_count = face_count - interior_count;
  if (symbol_count <= 0 || vertex_count < 0 || vertex_count > 0xffffffff || component_count > symbol_count || interior_count > component_count)
    refuse('counts that contradict each other');
  const starts = [interior_count > 0 ? 0xffffffff : 0], has_start_bits = interior_count > 0 && interior_count < component_count;
  for (let k = 0; has_start_bits && k < component_count; ++k) starts[k >> 5] = ((k & 31 ? starts[k >> 5] : 0) | (bits.bits(1) << (k & 31))) >>> 0;
  const split_count = bits.number(of_count), events = [];
  check_counts(vertex_count, face_count, data_count, symbol_count, split_symbol_count, split_count, end - begin);
  for (let i = 0, source = 0; i < split_count; ++i) {
    source += bits.number(of_event);
    const event = split_event(symbol_count, source, bits.number(of_event));
    event[2] = bits.bits(1);
    events.push(event);
  }
  const has_seams = Array.from({ length: data_count }, () => bits.flag());
  read_attribute_numbers(bits, tables, begin, face_count, stored);
  const border_count = tables.has_borders ? bits.number(new NumberKind(5)) : 0;
  if (border_count > point_count || stored[0].begin + kLeastSection > end) refuse('a broken first section');
  if (tables.has_borders && !stored[0].by_creation) refuse('a border part of other values');
  for (const one of stored) if (one.by_creation) one.scheme = kSchemeCreated;

  // The layout has places for bits of start faces and seams, and for valences if there is a list.
  const none = [0, 0, 0, 0];
  return { symbol_count, vertex_limit: vertex_count + split_symbol_count, events, symbols: 0, lists: tables.contexts.has_valences ? [none] : [],
    start_faces: none, seams: has_seams.map(() => none), groups, attributes, shape, body: 0, face_count, point_count, reference_count: 0, stream_bytes: 0,
    condensed: { tables, stored, starts, has_start_bits, has_seams, component_count, split_symbol_count, border_count, numbers_end: bits.taken(),
      has_grid: attributes.map(({ coding, scheme }) => coding === kCodingNormal && scheme !== kSchemeNone) } };
}
