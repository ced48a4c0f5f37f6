// The compressed streams of an asset, as decoders take them.

const kTypes = { 5120: 'int8', 5121: 'uint8', 5122: 'int16', 5123: 'uint16', 5125: 'uint32', 5126: 'float32' };
const kComponents = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };
const kKinds = { PSPLIT_mesh_draco_patches: 'container', KHR_draco_mesh_compression: 'draco' };

/**
 * @param {object} json of the asset
 * @param {(view: number) => Promise<ArrayBuffer>} bytes_of a buffer view
 * @returns {Promise<{kind: 'container' | 'draco', bytes: Uint8Array, attributes: object[]}[]>}
 */
export async function streams_of(json, bytes_of) {
  const streams = new Map();  // by buffer view
  for (const { primitives, extensions } of json.meshes ?? [])
    for (const primitive of extensions?.PSPLIT_mesh_draco_patches?.primitives ?? primitives)  // not the coarse ones
      for (const [extension, kind] of Object.entries(kKinds)) {
        const stored = primitive.extensions?.[extension];
        if (stored === undefined || streams.has(stored.bufferView)) continue;
        const attributes = Object.entries(stored.attributes).map(([name, uniqueId]) => {
          const { componentType, type, normalized = false } = json.accessors[primitive.attributes[name]];
          return { name, uniqueId, type: kTypes[componentType], componentCount: kComponents[type], normalized };
        });
        streams.set(stored.bufferView, { kind, attributes });
      }
  return Promise.all([...streams].map(async ([view, stream]) => ({ ...stream, bytes: new Uint8Array(await bytes_of(view)) })));
}

/** The streams of a GLB that has all its buffers. */
export function streams_of_glb(buffer) {
  const json_bytes = new DataView(buffer).getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, json_bytes)));
  return streams_of(json, async (view) => {
    const { byteOffset = 0, byteLength } = json.bufferViews[view], begin = 28 + json_bytes + byteOffset;
    return buffer.slice(begin, begin + byteLength);
  });
}

/**
 * Makes a GLB of a Draco stream.
 * @param {ArrayBuffer} bytes
 * @param {import('./psplit/index.js').Pool} pool
 * @returns {Promise<ArrayBuffer>}
 */
export async function glb_of_stream(bytes, pool) {
  const { attributes: stored, faceCount, pointCount } = await pool.decodeDraco(bytes);
  const names = { POSITION: 'POSITION', NORMAL: 'NORMAL', COLOR: 'COLOR_', TEX_COORD: 'TEXCOORD_', GENERIC: '_GENERIC_' }, counts = {};
  const attributes = {}, accessors = [{ componentType: 5125, type: 'SCALAR', count: 3 * faceCount }], ids = {};
  for (const { name, uniqueId, type, componentCount, normalized, array } of stored) {
    const number = (counts[name] = (counts[name] ?? -1) + 1), own = names[name].endsWith('_') ? names[name] + number : names[name];
    if (componentCount > 4 || (own === names[name] && number > 0)) continue;
    // Colours are parts of 1, and glTF has not all of Draco's types.
    const componentType = Number(Object.keys(kTypes).find((key) => kTypes[key] === type) ?? 5126);
    const accessor = { componentType, type: ['SCALAR', 'VEC2', 'VEC3', 'VEC4'][componentCount - 1], count: pointCount,
      normalized: normalized || (name === 'COLOR' && componentType < 5125) };
    if (name === 'POSITION') {
      const axes = [0, 1, 2].map((axis) => array.filter((_, i) => i % 3 === axis));
      accessor.min = axes.map((values) => values.reduce((a, b) => Math.min(a, b), Infinity));
      accessor.max = axes.map((values) => values.reduce((a, b) => Math.max(a, b), -Infinity));
    }
    attributes[own] = accessors.push(accessor) - 1;
    ids[own] = uniqueId;
  }
  const json = { asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], accessors,
    meshes: [{ primitives: [{ indices: 0, attributes, extensions: { KHR_draco_mesh_compression: { bufferView: 0, attributes: ids } } }] }],
    extensionsUsed: ['KHR_draco_mesh_compression'], extensionsRequired: ['KHR_draco_mesh_compression'],
    bufferViews: [{ buffer: 0, byteLength: bytes.byteLength }], buffers: [{ byteLength: bytes.byteLength }] };
  const text = new TextEncoder().encode(JSON.stringify(json)), text_bytes = (text.length + 3) & ~3, body_bytes = (bytes.byteLength + 3) & ~3;
  const glb = new Uint8Array(28 + text_bytes + body_bytes).fill(32, 20, 20 + text_bytes), view = new DataView(glb.buffer);
  const words = [[0, 0x46546c67, 2, glb.length, text_bytes, 0x4e4f534a], [20 + text_bytes, body_bytes, 0x004e4942]];
  for (const [at, ...values] of words) values.forEach((value, i) => view.setUint32(at + 4 * i, value, true));
  glb.set(text, 20);
  glb.set(new Uint8Array(bytes), 28 + text_bytes);
  return glb.buffer;
}

/**
 * The streams of a container without a head, which are ordinary Draco streams. Null for others. "Directory" of the specification
 * has the rows: numbers in bits, each a distance from what the rows before let expect.
 */
export function patches_of({ bytes, attributes }) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const [codec, count, directory_bytes, head_bytes] = bytes.length < 20 ? [1]
    : [view.getUint16(6, true), view.getUint32(8, true), view.getUint32(12, true), view.getUint32(16, true)];
  if (codec !== 0 || view.getUint8(4) !== 1 || head_bytes !== 0) return null;
  const rows = directory_rows(bytes.subarray(20, 20 + directory_bytes), count);
  let at = 20 + directory_bytes + rows.reduce((sum, { stitch_bytes }) => sum + stitch_bytes, 0);
  return rows.map(({ stream_bytes }) => ({ kind: 'draco', bytes: bytes.slice(at, (at += stream_bytes)), attributes }));
}

function directory_rows(directory, count) {
  let at = 0;
  const bits = (length) => {
    let value = 0;
    for (let i = 0; i < length; ++i, ++at) value += ((directory[at >> 3] >> (at & 7)) & 1) * 2 ** i;
    return value;
  };
  const column = (order, expected_of, follow) => {
    let state = 16 * order, mean = null;
    return (known) => {
      let zeros = 0;
      while (at < 8 * directory.length && bits(1) === 0) ++zeros;
      const low = Math.floor(state / 16), folded = (2 ** zeros - 1 + bits(zeros)) * 2 ** low + bits(low);
      state = Math.floor((3 * state + 16 * Math.floor(Math.log2(Math.max(1, folded)))) / 4);
      const expected = expected_of(mean ?? 0, known), step = folded % 2 === 0 ? folded / 2 : -(folded + 1) / 2;
      const value = (((expected + step) % 2 ** 32) + 2 ** 32) % 2 ** 32;
      mean = follow(mean, known, value, expected);
      return value;
    };
  };
  const sum = (order) => column(order, (mean, base) => base + Math.floor(mean / 16),
    (mean, base, value, expected) => (mean === null ? 16 * (value - base) : mean + value - expected));
  const ratio = (order) => column(order, (mean, scale) => Math.floor((mean * Math.max(scale, 1)) / 1024), (mean, scale, value) => {
    const now = Math.min(Math.floor((64 * value) / Math.max(scale, 1)), 2 ** 17 - 1);
    return mean === null ? 16 * now : mean + now - Math.floor(mean / 16);
  });
  const faces_of = sum(6), points_of = sum(3), references_of = sum(3), stitch_of = ratio(2), bytes_of = ratio(6);
  bits(1);  // no skeletons
  return Array.from({ length: count }, () => {
    const points = points_of(Math.floor(faces_of(0) / 2)), references = references_of(0);
    return { stitch_bytes: references > 0 ? stitch_of(references) : 0, stream_bytes: bytes_of(points) };
  });
}
