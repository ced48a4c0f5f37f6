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
  for (const { primitives } of json.meshes ?? [])
    for (const primitive of primitives)
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
 * The streams of a container of version 2, which are ordinary Draco streams. Null for other versions. The specification has
 * the layout: a header of 52 bytes with five columns, the columns' values, the stitch map, and the streams.
 */
export function patches_of({ bytes, attributes }) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 52 || view.getUint8(4) !== 2) return null;
  const count = view.getUint32(8, true);
  let at = 52;
  const columns = [12, 20, 28, 36, 44].map((header) => {
    const least = view.getUint32(header, true), width = view.getUint8(header + 4), first = at;
    at += 4 * Math.ceil((count * width) / 4);
    const read = { 0: () => 0, 1: (i) => view.getUint8(first + i), 2: (i) => view.getUint16(first + 2 * i, true),
      4: (i) => view.getUint32(first + 4 * i, true) }[width];
    return Array.from({ length: count }, (_, i) => least + read(i));
  });
  const [stream_bytes, , , , stitch_bytes] = columns;
  at += stitch_bytes.reduce((sum, value) => sum + value, 0);
  return stream_bytes.map((length) => ({ kind: 'draco', bytes: bytes.slice(at, (at += length)), attributes }));
}
