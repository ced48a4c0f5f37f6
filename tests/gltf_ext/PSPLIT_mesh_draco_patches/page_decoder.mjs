// A decoder of PSPLIT_mesh_draco_patches, written from its specification alone on top of a stock Draco decoder. It is an
// example, and it tests that the specification's page is complete. It must not use anything else of the project.
//
// Names in the comments ("Directory", "Border walk" ...) are sections of the page.

// condensed_streams.mjs has what only condensed streams need.
import { bit_reader, demand, kinds_of } from './bits.mjs';
import { expand_streams, parse_head } from './condensed_streams.mjs';

export { Invalid } from './bits.mjs';

// --- glTF ----------------------------------------------------------------------------------------------------

const kComponents = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };
const kComponentBytes = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };

// `load` returns the bytes of a URI.
export function parse_asset(file, load) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  if (view.getUint32(0, true) !== 0x46546c67) {
    const json = JSON.parse(new TextDecoder().decode(file));
    return { json, buffers: (json.buffers ?? []).map((buffer) => load(buffer.uri)) };
  }
  const json_bytes = view.getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(file.subarray(20, 20 + json_bytes)));
  return { json, buffers: (json.buffers ?? []).map(({ uri }) => (uri ? load(uri) : file.subarray(28 + json_bytes))) };
}

function buffer_view(asset, index) {
  const view = asset.json.bufferViews[index];
  const start = view.byteOffset ?? 0;
  return asset.buffers[view.buffer].subarray(start, start + view.byteLength);
}

// Tightly packed bytes. Padded matrices and sparse accessors are not supported, because the test has none.
export function accessor_bytes(asset, index) {
  const accessor = asset.json.accessors[index];
  const bytes = buffer_view(asset, accessor.bufferView);
  const size = kComponentBytes[accessor.componentType] * kComponents[accessor.type];
  const stride = asset.json.bufferViews[accessor.bufferView].byteStride ?? size;
  const packed = new Uint8Array(accessor.count * size);
  for (let i = 0; i < accessor.count; ++i) {
    const start = (accessor.byteOffset ?? 0) + i * stride;
    packed.set(bytes.subarray(start, start + size), i * size);
  }
  return packed;
}

export function accessor_indices(asset, index) {
  const { componentType, count } = asset.json.accessors[index];
  const packed = accessor_bytes(asset, index);
  const view = new DataView(packed.buffer);
  if (componentType === 5121) return Uint32Array.from(packed);
  const wide = componentType === 5125;
  return Uint32Array.from({ length: count }, (_, i) =>
    wide ? view.getUint32(4 * i, true) : view.getUint16(2 * i, true));
}

// --- a stock Draco decoder -----------------------------------------------------------------------------------

// The faces and points of one stream, and the values of each attribute in `requests`.
function decode_stream(draco, stream, requests) {
  // The bitstream's version and coding are read from its header, because the API does not return them.
  demand(stream.length > 8 && stream[5] === 2 && stream[6] === 2, 'not bitstream 2.2');
  const buffer = new draco.DecoderBuffer();
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  const memory = [];
  const copy_out = (bytes, fill) => {
    const at = draco._malloc(Math.max(1, bytes));
    memory.push(at);
    demand(fill(bytes, at), 'Draco returns no data');
    return draco.HEAPU8.slice(at, at + bytes);
  };
  try {
    buffer.Init(new Int8Array(stream.buffer, stream.byteOffset, stream.length), stream.length);
    demand(decoder.GetEncodedGeometryType(buffer) === draco.TRIANGULAR_MESH, 'not a mesh');
    const status = decoder.DecodeBufferToMesh(buffer, mesh);
    demand(status.ok() && mesh.ptr !== 0, `Draco: ${status.error_msg()}`);
    const points = mesh.num_points(), faces = mesh.num_faces();
    const corners = new Uint32Array(
      copy_out(12 * faces, (bytes, at) => decoder.GetTrianglesUInt32Array(mesh, bytes, at)).buffer);
    const draco_types = { 5120: draco.DT_INT8, 5121: draco.DT_UINT8, 5122: draco.DT_INT16, 5123: draco.DT_UINT16,
      5126: draco.DT_FLOAT32 };
    const values = requests.map(({ id, componentType, components }) => {
      const attribute = decoder.GetAttributeByUniqueId(mesh, id);
      demand(attribute.ptr !== 0, `no attribute ${id}`);
      demand(attribute.num_components() === components, `attribute ${id} has other components`);
      demand(attribute.data_type() === draco_types[componentType], `attribute ${id} has another type`);
      return copy_out(points * components * kComponentBytes[componentType], (bytes, at) =>
        decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, attribute.data_type(), bytes, at));
    });
    return { points, corners, values, sequential: stream[8] === 0 };
  } finally {
    for (const at of memory) draco._free(at);
    for (const object of [mesh, decoder, buffer]) draco.destroy(object);
  }
}

// --- the container -------------------------------------------------------------------------------------------

// "Directory". All numbers and products are below 2^53, so they are exact.
function directory_rows(part, count, has_residue) {
  const { bits, number, signed, end } = bit_reader(part, 'directory');
  const kinds = kinds_of({ count: 0, skeleton: 0, faces: 6, points: 3, references: 3, stitch: 2, bytes: 6 });
  const mean = {};
  const modulo = (value) => ((value % 2 ** 32) + 2 ** 32) % 2 ** 32;
  const near_sum = (column, base) => {
    const expected = base + Math.floor((mean[column] ?? 0) / 16);
    const value = modulo(expected + signed(kinds[column]));
    mean[column] = mean[column] === undefined ? 16 * (value - expected) : mean[column] + value - expected;
    return value;
  };
  const near_ratio = (column, known) => {
    const scale = Math.max(known, 1), last = mean[column];
    const value = modulo(Math.floor(((last ?? 0) * scale) / 1024) + signed(kinds[column]));
    const ratio = Math.min(Math.floor((64 * value) / scale), 2 ** 17 - 1);
    mean[column] = last === undefined ? 16 * ratio : last + ratio - Math.floor(last / 16);
    return value;
  };
  const skeleton_count = number(kinds.count);
  demand(skeleton_count <= 255, 'too many skeletons');
  const mixed = skeleton_count > 0 && bits(1) === 1;
  const rows = [];
  while (rows.length < count) {
    const is_residue = has_residue && rows.length === count - 1;
    const condensed = skeleton_count > 0 && !is_residue && (!mixed || bits(1) === 1);
    const skeleton = condensed && skeleton_count > 1 ? number(kinds.skeleton) : 0;
    demand(!condensed || skeleton < skeleton_count, 'a skeleton that does not exist');
    const faces = near_sum('faces', 0);
    const points = near_sum('points', Math.floor(faces / 2));
    const references = near_sum('references', 0);
    const stitch_bytes = references > 0 ? near_ratio('stitch', references) : 0;
    const stream_bytes = near_ratio('bytes', points);
    rows.push({ is_residue, condensed, skeleton, faces, points, references, stitch_bytes, stream_bytes });
  }
  end();
  return { rows, skeleton_count };
}

// "Parts". All sums are below 2^53, so they are exact.
export function parse_container(bytes) {
  demand(bytes.length >= 20, 'shorter than its header');
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  demand([0x50, 0x53, 0x50, 0x4c].every((letter, i) => bytes[i] === letter), 'wrong magic');
  demand(bytes[4] === 1, 'another version');
  demand((bytes[5] & 0xfe) === 0, 'unknown flags');
  demand(view.getUint16(6, true) === 0, 'another codec');
  const count = view.getUint32(8, true);
  const directory_end = 20 + view.getUint32(12, true), head_end = directory_end + view.getUint32(16, true);
  demand(head_end <= bytes.length, 'ends within its directory or head');
  demand(count >= 1 && count <= 2 * (directory_end - 20), 'an impossible number of streams');
  const { rows, skeleton_count } = directory_rows(bytes.subarray(20, directory_end), count, bytes[5] === 1);
  const head = parse_head(bytes.subarray(directory_end, head_end));
  demand(skeleton_count <= (head?.skeletons.length ?? 0), 'more skeletons than the head has');
  demand(head === null || rows.some(({ condensed }) => condensed), 'tables without condensed streams');
  let points = 0, faces = 0;
  for (const row of rows) {
    demand(row.stream_bytes >= 1, 'an empty stream');
    demand(row.is_residue || (row.faces >= 1 && row.points <= 3 * row.faces), 'an impossible patch');
    demand(row.references <= row.points, 'more references than points');
    demand((row.stitch_bytes === 0) === (row.references === 0), 'references and stitch map contradict each other');
    row.base = points;
    row.owned = row.points - row.references;
    points += row.owned;
    faces += row.faces;
  }
  demand(points <= 2 ** 32 - 2 && 3 * faces <= 2 ** 32 - 1, 'more than glTF can index');
  let at = head_end;
  const total = rows.reduce((sum, row) => sum + row.stitch_bytes + row.stream_bytes, at);
  demand(total === bytes.length, 'the length is not the sum of the parts');
  for (const [part, length] of [['stitch', 'stitch_bytes'], ['stream', 'stream_bytes']])
    for (const row of rows) {
      row[part] = bytes.subarray(at, at + row[length]);
      at += row[length];
    }
  return { rows, points, faces, head };
}

// "Border walk".
function border_walk(corners, points) {
  const key = (a, b) => a * points + b;
  const edges = new Set();
  for (let i = 0; i < corners.length; ++i) edges.add(key(corners[i], corners[i % 3 === 2 ? i - 2 : i + 1]));
  const successor = new Array(points).fill(-1);
  for (let i = 0; i < corners.length; ++i) {
    const a = corners[i], b = corners[i % 3 === 2 ? i - 2 : i + 1];
    if (edges.has(key(b, a))) continue;
    if (successor[a] !== -1) return [];
    successor[a] = b;
  }
  const walk = [];
  for (let start = 0; start < points; ++start) {
    if (successor[start] === -1) continue;
    let at = start;
    do {
      const next = successor[at];
      if (next === -1) return [];
      walk.push(at);
      successor[at] = -1;
      at = next;
    } while (at !== start);
  }
  return walk;
}

// "Stitch map": runs, repeats and pairs in the part of stream p.
function parse_stitch(row, p) {
  const runs = [], repeats = [], pairs = [];
  if (row.stitch.length === 0) return { runs, repeats, pairs };
  const { bits, number, signed, end } = bit_reader(row.stitch, 'stitch map');
  const log2 = (value) => Math.floor(Math.log2(value));
  const kinds = kinds_of({ count: 0, back: 0, place: Math.max(0, log2(row.points) - 1), walk_skip: 1, length: 1,
    start_step: 2, point_skip: log2(row.points / row.references), distance: 1, rank_step: 1 });
  let left = row.references;

  const run_count = number(kinds.count);
  demand(run_count <= left, 'more runs than references');
  let last = null;
  for (let r = 0; r < run_count; ++r) {
    const skip = number(kinds.walk_skip), length = number(kinds.length) + 1;
    demand(length <= left, 'more references than the row says');
    left -= length;
    const step = length > 1 && bits(1) === 1 ? 1 : -1;
    const begin = (last ? last.begin + last.length : 0) + skip;
    let owner, start;
    if (last === null || bits(1) === 1) {
      owner = p - number(kinds.back);
      demand(owner >= 0, 'an owner before stream 0');
      start = number(kinds.place);
    } else {
      owner = last.owner;
      start = last.start + last.step * (last.length + skip + signed(kinds.start_step));
      demand(start >= 0, "a run leaves its owner's walk");
    }
    last = { begin, length, step, owner, start };
    runs.push(last);
  }

  const pair_count = left > 0 && p > 0 ? number(kinds.count) : 0;
  demand(pair_count <= left, 'more pairs than references');
  const repeat_count = left - pair_count;
  const differences = repeat_count > 0 && bits(1) === 1;
  let next = 0, distance = 0;
  for (let r = 0; r < repeat_count; ++r) {
    const point = next + number(kinds.point_skip);
    distance = differences ? distance + signed(kinds.distance) : number(kinds.distance);
    demand(distance >= 0 && distance < point, 'a repeat of a point that does not exist');
    repeats.push({ point, target: point - 1 - distance });
    next = point + 1;
  }

  next = 0;
  let owner = null, rank = 0, way = -1;
  for (let r = 0; r < pair_count; ++r) {
    const point = next + number(kinds.point_skip);
    if (owner === null || bits(1) === 1) {
      owner = p - 1 - number(kinds.back);
      demand(owner >= 0, 'an owner before stream 0');
      rank = number(kinds.place);
    } else {
      const last_rank = rank;
      rank += way * (1 + signed(kinds.rank_step));
      way = rank < last_rank ? -1 : 1;
      demand(rank >= 0, 'a pair names a point that its owner does not own');
    }
    pairs.push({ point, owner, rank });
    next = point + 1;
  }
  end();
  return { runs, repeats, pairs };
}

// The mesh of a container: indices, the tightly packed values of every request, and which features of the format it uses.
export function decode_container(draco, bytes, requests) {
  const { rows, points, faces, head } = parse_container(bytes);
  const uses = { streams: rows.length, residues: 0, dropped_faces: 0, runs: 0, forward_runs: 0, repeats: 0, pairs: 0,
    condensed: 0, stored: 0 };
  const decode = (stream, wanted) => decode_stream(draco, stream, wanted);

  rows.forEach((row, p) => Object.assign(row, parse_stitch(row, p)));
  if (head) expand_streams(rows, head, decode, border_walk, uses);

  // "Streams".
  rows.forEach((row) => {
    if (head) uses[row.condensed ? 'condensed' : 'stored'] += 1;
    const decoded = decode(row.stream, requests);
    demand(decoded.sequential === row.is_residue, 'only the residue is sequential');
    demand(decoded.points === row.points, 'other points than the row says');
    const decoded_faces = decoded.corners.length / 3;
    const more = decoded_faces - row.faces;
    demand(row.is_residue ? more >= 0 : more === 0, 'other faces than the row says');
    uses.residues += row.is_residue ? 1 : 0;
    uses.dropped_faces += more;
    row.corners = decoded.corners.subarray(0, 3 * row.faces);
    row.values = decoded.values;
  });

  // "Border walk", computed only for runs; "Stitch map": which points are references.
  const walk_of = (row) => (row.walk ??= row.is_residue ? [] : border_walk(row.corners, row.points));
  for (const row of rows) {
    row.target = new Map(); // from a point that is a reference to its owner, with the owner's decoded point or a rank
    const refer = (point, target) => {
      demand(!row.target.has(point), 'a point is a reference twice');
      row.target.set(point, target);
    };
    for (const run of row.runs) {
      const walk = walk_of(row), owner = rows[run.owner], way = walk_of(owner);
      const last = run.start + run.step * (run.length - 1);
      demand(run.begin + run.length <= walk.length, 'a run leaves its walk');
      demand(run.start < way.length && last >= 0 && last < way.length, "a run leaves its owner's walk");
      for (let k = 0; k < run.length; ++k)
        refer(walk[run.begin + k], { owner, point: way[run.start + run.step * k] });
      uses.runs += 1;
      uses.forward_runs += run.step === 1 && run.length > 1 ? 1 : 0;
    }
    for (const { point, target } of row.repeats) {
      demand(point < row.points, 'a repeat of a point that does not exist');
      refer(point, { owner: row, point: target });
      uses.repeats += 1;
    }
    for (const pair of row.pairs) {
      const owner = rows[pair.owner];
      demand(pair.point < row.points, 'a pair of a point that does not exist');
      demand(pair.rank < owner.owned, 'a pair names a point that its owner does not own');
      refer(pair.point, { owner, rank: pair.rank });
      uses.pairs += 1;
    }
    demand(row.target.size === row.references, 'other references than the row says');
  }

  // "Numbering".
  for (const row of rows) {
    row.number = new Array(row.points).fill(-1);
    let next = row.base;
    for (let point = 0; point < row.points; ++point) if (!row.target.has(point)) row.number[point] = next++;
  }
  const indices = new Uint32Array(3 * faces);
  const values = requests.map(({ componentType, components }) =>
    new Uint8Array(points * components * kComponentBytes[componentType]));
  let corner = 0;
  for (const row of rows) {
    const resolved = row.number.slice();
    for (const [point, { owner, point: target, rank }] of row.target) {
      demand(rank !== undefined || !owner.target.has(target), 'the target of a reference is a reference');
      resolved[point] = rank !== undefined ? owner.base + rank : owner.number[target];
    }
    for (const point of row.corners) indices[corner++] = resolved[point];
    requests.forEach(({ componentType, components }, k) => {
      const size = components * kComponentBytes[componentType];
      for (let point = 0; point < row.points; ++point)
        if (!row.target.has(point))
          values[k].set(row.values[k].subarray(point * size, (point + 1) * size), row.number[point] * size);
      // "Conformance": copies in patches decode to the same bits. An owner is this stream or an earlier one, so its values
      // are decoded already.
      for (const point of row.is_residue ? [] : row.target.keys()) {
        const at = resolved[point] * size;
        for (let i = 0; i < size; ++i)
          if (values[k][at + i] !== row.values[k][point * size + i]) uses.unequal_copies = true;
      }
    });
  }
  return { points, indices, values, uses };
}

// The decoded primitive: points, indices, and for each semantic that the container stores its bytes. `targets` has the bytes
// of morph targets.
export function decode_primitive(draco, asset, primitive) {
  const extension = primitive.extensions.PSPLIT_mesh_draco_patches;
  const stored = Object.keys(extension.attributes).map((semantic) =>
    ({ semantic, id: extension.attributes[semantic], accessor: primitive.attributes[semantic] }));
  for (const [semantic, ids] of Object.entries(extension.targets ?? {})) {
    if (!Array.isArray(ids) || ids.length !== primitive.targets?.length) throw new Invalid('targets');
    ids.forEach((id, target) => {
      if (id !== -1) stored.push({ semantic, id, target, accessor: primitive.targets[target][semantic] });
    });
  }
  const requests = stored.map(({ id, accessor }) => {
    const { componentType, type } = asset.json.accessors[accessor];
    return { id, componentType, components: kComponents[type] };
  });
  const mesh = decode_container(draco, buffer_view(asset, extension.bufferView), requests);
  mesh.attributes = {};
  mesh.targets = (primitive.targets ?? []).map(() => ({}));
  stored.forEach(({ semantic, target }, k) => {
    (target === undefined ? mesh.attributes : mesh.targets[target])[semantic] = mesh.values[k];
  });
  return mesh;
}
