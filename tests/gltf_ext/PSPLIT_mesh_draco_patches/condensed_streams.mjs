// "Head" and "Condensed streams" of the specification, with their fields.
import { bit_reader, demand, kinds_of, unfold } from './bits.mjs';
import { attribute_table, decode_connectivity, inner_edges, kE, next, previous, swing_left, swing_right }
  from './corner_table.mjs';
import { decode_deltas, parse_deltas } from './deltas.mjs';
import { draco_order, kCanonicalized, kGeometricNormal, kMultiParallelogram, kNone, kNormals, kRaw, kTexCoords, kWrap,
  write_draco_stream } from './write_draco_stream.mjs';

// "Head": its sections by type.
function head_sections(part) {
  const sections = new Map();
  for (let at = 0, last = -1; at < part.length;) {
    const type = part[at++];
    let length = 0;
    for (let i = 0; ; ++i) {
      demand(at < part.length && i < 5, 'a section without a length');
      const byte = part[at++];
      length += (byte & 0x7f) * 2 ** (7 * i);
      if (byte < 0x80) break;
    }
    demand(type > last, 'sections that do not ascend by type');
    demand(length <= part.length - at, 'a section of more bytes than there are');
    demand((type >= 1 && type <= 3) || type >= 128, 'a section that is not known');
    sections.set(last = type, part.subarray(at, at + length));
    at += length;
  }
  return sections;
}

const sum = (frequencies) => frequencies.reduce((a, b) => a + b, 0);
function token_table(number, used_kind) {
  const used = number(used_kind);
  demand(used <= 116, 'too many tokens');
  const { frequency } = kinds_of({ frequency: 4 });
  const frequencies = Array.from({ length: used }, () => number(frequency));
  demand(used === 0 || sum(frequencies) === 4096, 'frequencies with another sum');
  return frequencies;
}

// What the sections have that this decoder knows; null if they have no tables.
export function parse_head(part) {
  const sections = head_sections(part);
  demand(sections.has(1) || !sections.has(2), 'values at borders without tables');
  demand(sections.has(1) || !sections.has(3), 'deltas without tables');
  if (!sections.has(1)) return null;
  const head = parse_tables(sections.get(1));
  head.border_tables = sections.has(2) ? parse_borders(sections.get(2)) : null;
  head.deltas = sections.has(3) ? parse_deltas(sections.get(3), head.attributes, token_table) : null;
  return head;
}

function parse_borders(part) {
  const { number, end } = bit_reader(part, 'section of borders'), { used } = kinds_of({ used: 5 });
  const tables = [token_table(number, used), token_table(number, used)];
  end();
  return tables;
}

function parse_tables(part) {
  const { bits, number, end } = bit_reader(part, 'section of tables');
  const kinds = kinds_of({ count: 0, length: 5, used: 5 });
  const times = (count, read) => Array.from({ length: count }, read);
  const probability = () => {
    const value = bits(12);
    demand(value > 0, 'a probability of 0');
    return value;
  };

  const skeleton_count = number(kinds.count) + 1;
  demand(skeleton_count <= 255, 'too many skeletons');
  const skeletons = times(skeleton_count, () => {
    const level = bits(4), length = number(kinds.length);
    demand(level <= 11, 'an impossible level of compression');
    demand(length <= 4096, 'a skeleton of an impossible length');
    return Uint8Array.from([...kSkeletonFront, ...times(length, () => bits(8))]);
  });

  const symbol_contexts = bits(4);
  demand(symbol_contexts <= 5 || symbol_contexts === 8, 'impossible contexts of symbols');
  const { frequency } = kinds_of({ frequency: 4 });
  const contexts = times(symbol_contexts === 8 ? 30 : 5 ** symbol_contexts, () => times(5, () => number(frequency)));
  demand(contexts.every((context) => [0, 4096].includes(sum(context))), 'frequencies with another sum');

  const attribute_count = number(kinds.count) + 1;
  demand(attribute_count <= 256, 'too many attributes');
  let all_sets = 0;
  const attributes = times(attribute_count, () => {
    const by_creation = bits(1) === 1;
    const [backward, two, mean] = times(3, () => by_creation && bits(1) === 1);
    const reach = by_creation ? bits(2) : 0;
    demand(reach <= 2, 'an impossible reach');
    const set_count = number(kinds.count) + 1;
    demand(set_count <= 8 && (all_sets += set_count) <= 256, 'too many sets of tables');
    const sets = times(set_count, () => times(by_creation ? 3 : 2, () => token_table(number, kinds.used)));
    const flags = bits(1) === 1
      ? { creases: times(4, probability), orientations: probability(), flips: probability() } : null;
    return { by_creation, backward, two, mean, reach, sets, flags };
  });
  const data_count = number(kinds.count);
  demand(data_count <= 128, 'too many attribute data');
  const seams = times(data_count, () => times(2, probability));
  end();
  return { skeletons, symbol_contexts, contexts, attributes, seams };
}

// DRACO, bitstream 2.2, a mesh, Edgebreaker.
const kSkeletonFront = [0x44, 0x52, 0x41, 0x43, 0x4f, 2, 2, 1, 1];

// The literal bytes of a skeleton, and what they say of the attributes.
function parse_skeleton(bytes) {
  let at = 0;
  const u8 = () => {
    demand(at < bytes.length, 'a skeleton breaks off');
    return bytes[at++];
  };
  const skip = (count) => { for (let i = 0; i < count; ++i) u8(); };
  const since = (start) => bytes.subarray(start, at);
  const varint = () => {
    let value = 0;
    for (let i = 0; ; ++i) {
      const byte = u8();
      demand(i < 4 || byte <= 15, 'a number of more than 32 bits in a skeleton');
      value += (byte & 0x7f) * 2 ** (7 * i);
      if (byte < 0x80) return value;
    }
  };
  const skip_metadata = () => {
    for (let entries = varint(); entries > 0; --entries) {
      skip(u8());
      skip(varint());
    }
    for (let children = varint(); children > 0; --children) {
      skip(u8());
      skip_metadata();
    }
  };

  skip(kSkeletonFront.length + 1);
  if ((u8() & 0x80) !== 0) {
    for (let attributes = varint(); attributes > 0; --attributes) {
      varint();
      skip_metadata();
    }
    skip_metadata();
  }
  const front = since(0), traversal = u8();
  demand(traversal === 0 || traversal === 2, 'an impossible traversal');
  const data_count = u8(), descriptions_start = at;

  const decoders = Array.from({ length: u8() }, () =>
    ({ data: (u8() << 24) >> 24, at_corners: u8() !== 0, traversal: u8() }));
  const attributes = [];
  for (const decoder of decoders) {
    demand(decoder.data < data_count && (decoder.data >= 0 || !decoder.at_corners), 'attribute data that do not exist');
    decoder.attributes = Array.from({ length: varint() }, () => {
      skip(1);
      const data_type = u8(), components = u8();
      skip(1);
      varint();
      const attribute = { decoder, data_type, components, place: attributes.length };
      attributes.push(attribute);
      return attribute;
    });
    for (const attribute of decoder.attributes) attribute.type = u8();
  }
  const descriptions = since(descriptions_start);

  for (const decoder of decoders) {
    for (const attribute of decoder.attributes) {
      demand(attribute.type <= kNormals, 'an impossible type of a decoder');
      attribute.bytes = [0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1][attribute.data_type];
      if (attribute.type === kRaw) {
        demand(attribute.bytes <= 4, 'raw components of 8 bytes');
        continue;
      }
      attribute.scheme = (u8() << 24) >> 24;
      attribute.transform = attribute.scheme === kNone ? 0 : u8();
      demand(u8() !== 0, 'symbols that are not coded');
      const start = at, octahedral = attribute.transform > kWrap;
      demand(attribute.transform <= kCanonicalized, 'an impossible transform');
      demand(attribute.scheme === kNone || octahedral === (attribute.type === kNormals), 'a transform of other attributes');
      skip(octahedral ? (attribute.transform === kCanonicalized ? 8 : 4) : 0);
      attribute.transform_data = since(start);
      const stated = octahedral ? attribute.transform_data[0] + attribute.transform_data[1] * 2 ** 8 +
        attribute.transform_data[2] * 2 ** 16 + attribute.transform_data[3] * 2 ** 24 : 3;
      demand(stated % 2 === 1 && stated > 1 && stated < 2 ** 30, 'a grid of normals that does not exist');
      attribute.greatest = 2 ** Math.ceil(Math.log2(stated + 1)) - 1;
    }
    const start = at;
    for (const { type, components } of decoder.attributes) skip(type === 2 ? 4 * components + 5 : type === kNormals ? 1 : 0);
    decoder.transforms = since(start);
  }
  return { front, data_count, descriptions, decoders, attributes };
}

// "Sections": decisions of the entropy coder. Plain bits come from `bits`, which reads the section from its end.
function section(bytes, { bits, bytes_taken }) {
  let at = 0;
  const word = () => {
    demand(at + 2 <= bytes.length, 'a section ends within its words');
    at += 2;
    return bytes[at - 2] + 256 * bytes[at - 1];
  };
  let state = word() + 65536 * word();
  const take = (first, frequency) => {
    state = frequency * Math.floor(state / 4096) + (state % 4096) - first;
    if (state < 65536) state = 65536 * state + word();
  };
  const decode = (table) => {
    let first = 0, symbol = 0;
    while (symbol < table.length && first + table[symbol] <= state % 4096) first += table[symbol++];
    demand(symbol < table.length, 'coded with a table in which nothing is coded');
    take(first, table[symbol]);
    return symbol;
  };
  const flag = (probability) => {
    const is_set = state % 4096 < probability;
    take(is_set ? 0 : probability, is_set ? probability : 4096 - probability);
    return is_set ? 1 : 0;
  };
  const token_value = (table) => {
    const t = decode(table);
    if (t < 64) return t;
    const n = Math.floor((t - 64) / 2) + 5;
    return (2 + (t % 2)) * 2 ** n + bits(n);
  };
  const end = () => {
    demand(state === 65536, 'the last state of a section');
    demand(at + bytes_taken() === bytes.length, 'words and bits do not fill a section');
  };
  return { decode, flag, token_value, signed_value: (table) => unfold(token_value(table)), end };
}

// A bit reader that begins with the last byte.
const from_the_end = (bytes) => bit_reader(Uint8Array.from(bytes).reverse(), 'section');

const count_use = (uses, use, times = 1) => { uses[use] = (uses[use] ?? 0) + times; };

// "Order of creation": values[vertex][component]. Known values are there before.
function values_by_creation(coder, attribute, { two, mean, reach }, uses) {
  const { table: { opposite, vertex, corner_of }, tables } = attribute, components = width_of(attribute);
  const values = attribute.known.slice(), known_count = values.length;
  const table = { opposite, vertex };
  const zeros = new Array(components).fill(0);
  const combine = (f, ...others) => zeros.map((_, k) => f(...others.map((other) => other[k])) | 0);
  const middle = (p, q) => combine((x, y) => x + (((y - x) | 0) >> 1), p, q);
  corner_of.forEach((c, i) => {
    if (i < known_count) return;
    const before = (corner) => vertex[corner] < i;
    const at = (corner) => values[vertex[corner]];
    const found = [];
    for (const candidate of two ? [c, swing_left(table, c), swing_right(table, c)] : [c]) {
      const o = candidate === -1 ? -1 : opposite[candidate], a = next(candidate), b = previous(candidate);
      if (o === -1 || !before(a) || !before(b) || !before(o) || found.length === 2) continue;
      const whole = combine((x, y, far) => x + y - far, at(a), at(b), at(o)), edge = middle(at(a), at(b));
      found.push(reach === 0 ? whole : combine((p, h) => p - (((p - h) | 0) >> reach), whole, edge));
    }
    const a = next(c), b = previous(c);
    const predicted = found.length === 2 ? middle(...found)
      : found.length === 1 ? found[0]
        : before(a) && before(b) ? (mean ? middle(at(a), at(b)) : at(a))
          : before(a) ? at(a) : before(b) ? at(b) : i > known_count ? values[i - 1] : zeros;
    count_use(uses, `values_by_${found.length}_parallelograms`);
    values.push(predicted.map((value) => (value + coder.signed_value(tables[found.length])) | 0));
  });
  return values;
}

// The symbols of a value.
// The one name of a place on the octahedral grid, whose numbers are at most m.
function canonical([s, t], m) {
  const on_side = (x) => x === 0 || x === m;
  if (on_side(s) && on_side(t)) return [m, m];
  if ((s === 0 && t > m / 2) || (s === m && t < m / 2)) return [s, m - t];
  if ((t === m && s < m / 2) || (t === 0 && s > m / 2)) return [m - s, t];
  return [s, t];
}

const width_of = ({ type, components }) => (type === kNormals ? 2 : components);

// A condensed attribute in Draco's order: what its Draco stream has for it.
function read_in_draco_order(coder, attribute, count, { flags }) {
  const { type, scheme, transform, greatest, flag_counts, tables } = attribute;
  const width = width_of(attribute), symbols = [];
  for (let i = 0; i < count * width; ++i) {
    const table = tables[i < 3 * width ? 0 : 1];
    if (type === kRaw) {
      const sum = (symbols[i - width] ?? 0) + coder.signed_value(table), modulus = 2 ** (8 * attribute.bytes);
      symbols.push(((sum % modulus) + modulus) % modulus);
    } else if (transform > kWrap) {
      const c = coder.signed_value(table);
      demand(Math.abs(c) <= (greatest - 1) / 2, 'a correction of a normal out of its range');
      symbols.push(c >= 0 ? c : c + greatest);
    } else {
      symbols.push(coder.token_value(table));
    }
  }
  const list = (length, probability) => Array.from({ length }, () => {
    demand(flags !== null, 'flags without probabilities');
    return coder.flag(probability(flags));
  });
  const creases = scheme === kMultiParallelogram ? flag_counts.map((n, k) => list(n, (own) => own.creases[k])) : [];
  const orientations = scheme === kTexCoords ? list(flag_counts[0], (own) => own.orientations) : [];
  const flips = scheme === kGeometricNormal ? list(count, (own) => own.flips) : [];
  return { symbols, creases, orientations, flips };
}

// "Condensed streams": the numbers of the stream of a row, and its border part.
function begin_stream(row, head, uses) {
  const { stream, faces, points } = row;
  const skeleton = parse_skeleton(head.skeletons[row.skeleton]);
  demand(skeleton.attributes.length <= head.attributes.length && skeleton.data_count <= head.seams.length,
    'more attributes than the head has');
  const plain = from_the_end(stream);
  const { bits, number, signed } = plain;
  const kinds = kinds_of({ count: 0, vertices: 0, splits: 2, event: 8, bytes: 8, low: 12, extent: 12, flags: 8,
    border: 5 });
  const fields = { faces };
  const interior = fields.interior = number(kinds.count);
  fields.vertices = points - signed(kinds.vertices);
  fields.splits = number(kinds.splits);
  const components = number(kinds.count) + 1;
  demand(interior <= components && interior < faces && components <= faces, 'impossible start faces');
  demand(fields.vertices >= 0 && 16 * (faces + fields.vertices + points) <= 2 ** 26 + 4096 * stream.length,
    'claims more than its bytes justify');
  const some = interior > 0 && interior < components;
  fields.start_faces = Array.from({ length: components }, () => (some ? bits(1) : interior > 0 ? 1 : 0));
  const event_count = number(kinds.count);
  demand(event_count <= faces, 'too many split events');
  let source = 0;
  fields.symbol_count = faces - interior;
  fields.events = Array.from({ length: event_count }, () => {
    source += number(kinds.event);
    const split = source - number(kinds.event);
    demand(source < fields.symbol_count && split >= 0, 'an impossible split event');
    return { source, split, edge: bits(1) };
  });
  fields.has_seams = Array.from({ length: skeleton.data_count }, () => bits(1));
  const is_delta = ({ place }) => head.attributes[place].is_delta === true;
  const lengths = skeleton.attributes.map((attribute) =>
    (attribute.place > 0 && !is_delta(attribute) ? number(kinds.bytes) : 0));
  const deltas = skeleton.attributes.filter(is_delta), is_row = deltas.map(() => bits(1) === 1);
  const delta_lengths = is_row.includes(true) ? [0, 1, 2, 3].map(() => number(kinds.bytes)) : [];
  const attributes = skeleton.attributes.map((attribute) => ({ ...attribute, by_creation:
    head.attributes[attribute.place].by_creation && attribute.type !== kRaw &&
    (attribute.type === kNormals ? [kNone, 0] : [kNone, 0, 1]).includes(attribute.scheme) }));
  for (const attribute of attributes)
    if (!attribute.by_creation && attribute.transform === kWrap) {
      attribute.low = signed(kinds.low);
      attribute.high = attribute.low + number(kinds.extent);
    }
  for (const attribute of attributes) {
    const lists = attribute.scheme === kMultiParallelogram ? 4 : attribute.scheme === kTexCoords ? 1 : 0;
    attribute.flag_counts = Array.from({ length: lists }, () => number(kinds.flags));
    demand(attribute.flag_counts.every((count) => count <= 3 * faces), 'too many flags');
  }

  for (const attribute of attributes) {
    const { sets } = head.attributes[attribute.place], set = bits(Math.ceil(Math.log2(sets.length)));
    demand(set < sets.length, 'a set of tables that does not exist');
    attribute.tables = sets[set];
    count_use(uses, 'other_sets', Number(set > 0));
  }

  const border_count = head.border_tables ? number(kinds.border) : 0;
  demand(border_count <= points, 'more border points than points');

  // The places of the sections.
  const main_start = [...lengths, ...delta_lengths].reduce((sum, length) => sum + length, 0);
  demand(main_start <= stream.length, 'sections that do not fit');
  let at = 0;
  const next_section = (length) => {
    const bytes = stream.subarray(at, at + length);
    at += length;
    return section(bytes, from_the_end(bytes));
  };
  const coders = attributes.map((attribute, place) => {
    if (place === 0) return section(stream.subarray(main_start), plain);
    return is_delta(attribute) ? null : next_section(lengths[place]);
  });
  fields.deltas = { is_row, coders: delta_lengths.map(next_section) };
  for (const { by_creation, decoder, type, components } of attributes.filter(is_delta))
    demand(by_creation && decoder === attributes[0].decoder && type !== kNormals && components === 3,
      'deltas of other values');
  const main = coders[0] ?? section(stream, plain);
  demand(!head.border_tables || attributes[0]?.by_creation, 'borders without an attribute in order of creation');
  let last = null;
  fields.border_part = Array.from({ length: border_count }, () => last = Array.from({ length: width_of(attributes[0]) },
    (_, k) => ((last?.[k] ?? 0) + main.signed_value(head.border_tables[last ? 1 : 0])) | 0));
  count_use(uses, 'border_values', border_count);
  count_use(uses, 'split_events', event_count);
  count_use(uses, 'other_skeletons', Number(row.skeleton > 0));
  return { row, skeleton, fields, attributes, coders, main };
}

// "Connectivity". Draco's decoder says the points and the order of values.
function decode_mesh({ skeleton, fields, main }, head, decode, uses) {
  const { faces, interior } = fields;
  fields.symbols = [kE];
  const { symbol_contexts } = head, context_count = head.contexts.length;
  let context = context_count - 1;
  fields.mesh = decode_connectivity(faces, fields.symbol_count, fields.events, fields.start_faces, (valence) => {
    if (symbol_contexts === 8) context = 5 * (Math.min(7, Math.max(2, valence)) - 2) + fields.symbols.at(-1);
    const symbol = main.decode(head.contexts[context]);
    context = (5 * context + symbol) % context_count;
    fields.symbols.push(symbol);
    return symbol;
  });
  demand(fields.mesh.splits === fields.splits, 'another number of S');
  demand(fields.start_faces.filter((flag) => flag === 1).length === interior, 'other start faces');
  const edges = inner_edges(fields.mesh);
  fields.seams = fields.has_seams.map((any, data) => {
    let last = 0;
    return edges.map(() => (last = any === 1 ? main.flag(head.seams[data][last]) : 0));
  });
  fields.cuts_of = (decoder) => (decoder.at_corners ? edges.filter((_, e) => fields.seams[decoder.data][e] === 1) : []);
  count_use(uses, symbol_contexts === 8 ? 'valence_contexts' : 'history_contexts');
  count_use(uses, 'seams', fields.seams.flat().filter((seam) => seam === 1).length);
  Object.assign(fields, draco_order(skeleton, fields, decode));
}

// "Borders": for each place of the walk of a stream, the value there.
function walk_values(row, streams) {
  const { walk } = row, targets = [];
  for (const run of row.runs) {
    const way = run.owner_row.walk, last = run.start + run.step * (run.length - 1);
    demand(run.begin + run.length <= walk.length, 'a run leaves its walk');
    demand(run.start < way.length && last >= 0 && last < way.length, "a run leaves its owner's walk");
    for (let k = 0; k < run.length; ++k) targets[run.begin + k] = [run.owner_row, run.start + run.step * k];
  }
  const own = ({ runs }, place) => {
    const references = runs.flatMap(({ begin, length }) => Array.from({ length }, (_, k) => begin + k));
    demand(!references.includes(place), 'the target of a reference is a reference');
    return place - references.filter((other) => other < place).length;
  };
  return walk.map((_, place) => {
    const [owner, at] = targets[place] ?? [row, place];
    const value = streams.get(owner)?.fields.border_part[own(owner, at)];
    demand(value !== undefined, 'a border point without a value');
    return value;
  });
}

// "Attributes".
function read_attributes({ fields, attributes, coders, main }, known, head, uses) {
  attributes.forEach((attribute, place) => {
    if (head.attributes[place].is_delta) return;
    const { decoder } = attribute, entry = head.attributes[place], own = place === 0 ? known : new Map();
    const corners = [...own.keys()];
    const backward = attribute.by_creation && entry.backward;
    attribute.table = attribute_table(fields.mesh, fields.cuts_of(decoder), backward, corners);
    // The corners of several places may have the same vertex: the lowest place wins.
    attribute.known = attribute.table.corner_of.slice(0, attribute.table.known_count).map((corner) => own.get(corner));
    const count = attribute.table.corner_of.length, coder = coders[place];
    if (attribute.by_creation)
      attribute.values = values_by_creation(coder, attribute, entry, uses);
    else
      Object.assign(attribute, read_in_draco_order(coder, attribute, count, entry));
    demand(!attribute.values || attribute.transform <= kWrap ||
      attribute.values.flat().every((value) => value >= 0 && value < attribute.greatest), 'a normal beyond its grid');
    if (attribute.by_creation && attribute.transform > kWrap)
      attribute.values = attribute.values.map((value) => canonical(value, attribute.greatest - 1));
    if (place > 0) coder.end();
    count_use(uses, 'backward', Number(attribute.by_creation && entry.backward));
    count_use(uses, 'means', Number(attribute.by_creation && entry.mean));
    count_use(uses, 'reaches', Number(attribute.by_creation && entry.reach > 0));
    count_use(uses, 'plain_normals', Number(attribute.by_creation && attribute.type === kNormals));
    count_use(uses, 'raw_values', attribute.type === kRaw ? count : 0);
    for (const list of ['creases', 'orientations', 'flips']) count_use(uses, list, attribute[list]?.flat().length ?? 0);
  });
  main.end();
  read_deltas(fields, attributes, head, uses);
}

// "Deltas": in the table of attribute 0, which has the places of vertices.
function read_deltas({ mesh, deltas, cuts_of }, attributes, head, uses) {
  if (deltas.is_row.length === 0) return;
  const [first] = attributes, table = attribute_table(mesh, cuts_of(first.decoder), true);
  const place_of = (corner) => {
    const value = first.values?.[first.table.vertex[corner]] ?? [];
    return [0, 1, 2].map((k) => value[k] ?? 0);
  };
  const values = decode_deltas(head.deltas, deltas.is_row, table, place_of, deltas.coders, uses);
  deltas.is_row.forEach((_, n) => Object.assign(attributes[head.deltas.models[n].attribute], { table, values: values[n] }));
}

// "Expanding": sets the Draco stream of every row whose stream is condensed. `decode` is a stock decoder, and
// border_walk(corners, points) the walk.
export function expand_streams(rows, head, decode, border_walk, uses) {
  const streams = new Map(rows.filter(({ condensed }) => condensed).map((row) => [row, begin_stream(row, head, uses)]));
  for (const stream of streams.values()) decode_mesh(stream, head, decode, uses);
  if (head.border_tables)
    for (const row of rows) {
      demand(row.condensed || row.is_residue, 'borders and a stored patch');
      const width = (of) => width_of(streams.get(of).attributes[0]);
      demand(row.is_residue || width(row) === width(rows[0]), 'border values of different components');
      row.walk = row.is_residue ? [] : border_walk(streams.get(row).fields.corners, row.points);
      for (const run of row.runs) run.owner_row = rows[run.owner];
    }
  for (const [row, stream] of streams) {
    const { fields } = stream, known = new Map(); // by corner
    if (head.border_tables) {
      const values = walk_values(row, streams);
      const in_runs = row.runs.reduce((sum, { length }) => sum + length, 0);
      demand(fields.border_part.length + in_runs === row.walk.length, 'another number of border points');
      row.walk.forEach((point, place) => known.set(fields.corners.indexOf(point), values[place]));
    }
    read_attributes(stream, known, head, uses);
    row.stream = write_draco_stream(stream);
  }
}
