// Writes a Draco stream of fields that a stock decoder accepts. Its symbols are not entropy-coded, so it has other bytes
// than libdraco's.

import { attribute_table } from './corner_table.mjs';

// The numbers of Draco.
export const kRaw = 0, kNormals = 3; // types of decoders; 1 and 2 are integers and quantized values
export const kNone = -2, kMultiParallelogram = 4, kTexCoords = 5, kGeometricNormal = 6; // schemes
export const kWrap = 1, kCanonicalized = 3; // transforms

// The bytes of bits as Draco's rAbs coder decodes them, all with the same probability.
function coded_bits(flags) {
  const bytes = [];
  let state = 4096;
  for (const flag of flags.slice().reverse()) {
    if (state >= 4096 * 128) {
      bytes.push(state % 256);
      state = Math.floor(state / 256);
    }
    state = Math.floor(state / 128) * 256 + (state % 128) + (flag === 1 ? 0 : 128);
  }
  state -= 4096;
  const length = state < 2 ** 6 ? 1 : state < 2 ** 14 ? 2 : 3;
  for (let k = 0; k < length; ++k) bytes.push(Math.floor(state / 256 ** k) % 256);
  bytes[bytes.length - 1] += 64 * (length - 1);
  return [128, ...varint(bytes.length), ...bytes];
}

function varint(value) {
  return value < 128 ? [value] : [(value % 128) + 128, ...varint(Math.floor(value / 128))];
}
const integer = (value, size) => Array.from({ length: size }, (_, k) => Math.floor((value >>> 0) / 256 ** k) % 256);
const i32 = (value) => integer(value, 4);
function packed_bits(bits) {
  const bytes = new Array(Math.ceil(bits.length / 8)).fill(0);
  bits.forEach((bit, i) => { bytes[i >> 3] |= bit << (i & 7); });
  return bytes;
}

// Everything before the decoders of attributes, with the standard traversal.
function connectivity_bytes({ front, data_count }, { vertices, faces, splits, symbols, events, start_faces, seams }) {
  let last = 0;
  const deltas = events.flatMap(({ source, split }) => {
    const delta = source - last;
    last = source;
    return [...varint(delta), ...varint(source - split)];
  });
  const symbol_bits = packed_bits(symbols.flatMap((symbol) => [[0], [1, 0, 0], [1, 1, 0], [1, 0, 1], [1, 1, 1]][symbol]));
  return [...front, 0, ...varint(vertices), ...varint(faces), data_count, ...varint(symbols.length), ...varint(splits),
    ...varint(events.length), ...deltas, ...packed_bits(events.map(({ edge }) => edge)),
    ...varint(symbol_bits.length), ...symbol_bits, ...coded_bits(start_faces), ...seams.flatMap(coded_bits)];
}

// The points of the faces, and Draco's order of the values of each decoder: the rank of the value at each corner. The stock
// decoder says them: it decodes a stream of the same mesh whose only attributes are these ranks, as raw floats.
export function draco_order(skeleton, fields, decode) {
  const used = skeleton.decoders, kGeneric = 4, kFloat32 = 9;
  const ranks_of = (decoder) => Float32Array.from(attribute_table(fields.mesh, fields.cuts_of(decoder)).corner_of.keys());
  const bytes = [...connectivity_bytes(skeleton, fields), used.length,
    ...used.flatMap(({ data, at_corners, traversal }) => [data & 255, at_corners ? 1 : 0, traversal]),
    ...used.flatMap((_, id) => [1, kGeneric, kFloat32, 1, 0, id, kRaw]),
    ...used.flatMap((decoder) => [...new Uint8Array(ranks_of(decoder).buffer)])];
  const requests = used.map((_, id) => ({ id, componentType: 5126, components: 1 }));
  const { corners, values } = decode(Uint8Array.from(bytes), requests);
  return { corners, ranks: new Map(used.map((decoder, id) => {
    const rank_of_point = new Float32Array(values[id].buffer);
    return [decoder, [...corners].map((point) => rank_of_point[point])];
  })) };
}

// The bytes of an attribute. Its symbols are stored as they are, in four bytes each.
function attribute_bytes(attribute, ranks) {
  const { type, scheme, transform } = attribute;
  if (attribute.by_creation) {
    const ordered = [], rank_at = ranks.get(attribute.decoder);
    attribute.values.forEach((value, vertex) => { ordered[rank_at[attribute.table.corner_of[vertex]]] = value; });
    return [kNone & 255, 0, 4, ...ordered.flat().flatMap((value) => i32(value < 0 ? -2 * value - 1 : 2 * value))];
  }
  const { symbols, creases, orientations, flips } = attribute;
  if (type === kRaw) return symbols.flatMap((symbol) => integer(symbol, attribute.bytes));
  return [scheme & 255, ...(scheme === kNone ? [] : [transform]), 0, 4, ...symbols.flatMap(i32),
    ...creases.flatMap((list) => [...varint(list.length), ...(list.length > 0 ? coded_bits(list) : [])]),
    ...(scheme === kTexCoords ? [...i32(orientations.length), ...coded_bits(orientations)] : []),
    ...(transform === kWrap ? [...i32(attribute.low), ...i32(attribute.high)] : attribute.transform_data),
    ...(scheme === kGeometricNormal ? coded_bits(flips) : [])];
}

export function write_draco_stream({ skeleton, fields, attributes }) {
  const of_decoder = (decoder) => [
    ...attributes.flatMap((attribute) => (attribute.decoder === decoder ? attribute_bytes(attribute, fields.ranks) : [])),
    ...decoder.transforms];
  return Uint8Array.from([...connectivity_bytes(skeleton, fields), ...skeleton.descriptions,
    ...skeleton.decoders.flatMap(of_decoder)]);
}
