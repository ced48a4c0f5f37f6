// The meshes of bench.mjs: the primitives of an asset, in each coding.
import { readdirSync } from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { brotliCompressSync } from 'node:zlib';
import { compressed_primitives, modules_folder, read_asset } from '../../tests/web/load.mjs';

const kExtensions = { stock: 'KHR_draco_mesh_compression', patches: 'PSPLIT_mesh_draco_patches',
  condensed: 'PSPLIT_mesh_draco_patches' };

/** The names of a folder's meshes, each with the file NAME.stock.glb, and others. */
export const names_in = (folder) => readdirSync(folder).filter((file) => file.endsWith('.stock.glb')).map((file) => file.slice(0, -'.stock.glb'.length)).sort();

/** A mesh in one coding: what a decoder of that coding is given, for each primitive. In meshoptimizer's, a mesh is one primitive. */
export async function read_primitives(folder, name, stored) {
  const compressed = (kind) => compressed_primitives(path.join(folder, `${name}.${kind}.glb`), kExtensions[kind]);
  if (stored !== 'meshopt') return compressed(stored);
  return [await encoded_by_meshoptimizer(path.join(folder, `${name}.plain.glb`), compressed('stock')[0].attributes.map((attribute) => attribute.name))];
}

/** A mesh in some codings: `primitives` and `bytes` by coding. meshoptimizer's bytes are those in brotli. */
export async function read_mesh(folder, name, codings) {
  const primitives = {}, bytes = {};
  for (const stored of new Set(codings)) {
    primitives[stored] = await read_primitives(folder, name, stored);
    bytes[stored] = primitives[stored].reduce((sum, primitive) => sum + (primitive.brotli_bytes ?? primitive.bytes.length), 0);
  }
  return { primitives, bytes };
}

const kArrays = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const kComponents = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

const kHighestLevel = 3, kCodec = 1;  // of attributes, the newest

// A primitive as meshoptimizer's newest codec stores it, on the grids of the Draco streams: positions of 14 bits, normals of 10, texture
// coordinates of 12. Triangles are in an order that the codec likes, and points in the order of their use.
async function encoded_by_meshoptimizer(plain, names) {
  const { MeshoptEncoder } = await import(pathToFileURL(
    path.join(modules_folder, 'node_modules/meshoptimizer/meshopt_encoder.js')));
  await MeshoptEncoder.ready;
  const { json, view_bytes } = read_asset(plain);
  const [primitive, ...more] = json.meshes.flatMap(({ primitives }) => primitives);
  if (more.length > 0) throw new Error(`${plain}: one primitive is read`);
  const values_of = (accessor) => {
    const { bufferView, byteOffset = 0, count, type, componentType } = json.accessors[accessor];
    if (json.bufferViews[bufferView].byteStride !== undefined) throw new Error(`${plain}: interleaved accessors are not read`);
    const bytes = view_bytes(bufferView).slice(byteOffset);
    return { values: new kArrays[componentType](bytes.buffer, 0, count * kComponents[type]), components: kComponents[type], count };
  };
  const indices = Uint32Array.from(values_of(primitive.indices).values);
  const streams = names.map((name) => quantized(name, values_of(primitive.attributes[name]), MeshoptEncoder));
  const [remap, point_count] = MeshoptEncoder.reorderMesh(indices, true, true);
  const moved = ({ bytes, stride }) => {
    const out = new Uint8Array(point_count * stride);
    remap.forEach((to, from) => to !== 0xffffffff && out.set(bytes.subarray(from * stride, (from + 1) * stride), to * stride));
    return out;
  };
  const result = { index_count: indices.length, point_count,
    indices: MeshoptEncoder.encodeGltfBuffer(new Uint8Array(indices.buffer), indices.length, 4, 'TRIANGLES'),
    streams: streams.map((stream) => ({ stride: stream.stride, filter: stream.filter,
      bytes: MeshoptEncoder.encodeVertexBufferLevel(moved(stream), point_count, stream.stride, kHighestLevel, kCodec) })) };
  // At its highest quality.
  result.brotli_bytes = brotliCompressSync(Buffer.concat([result.indices, ...result.streams.map(({ bytes }) => bytes)])).length;
  return result;
}

function quantized(name, { values, components, count }, encoder) {
  if (name === 'NORMAL') {
    const vectors = new Float32Array(4 * count);
    for (let i = 0; i < count; ++i) vectors.set(values.subarray(3 * i, 3 * i + 3), 4 * i);
    return { bytes: encoder.encodeFilterOct(vectors, count, 8, 10), stride: 8, filter: 'OCTAHEDRAL' };
  }
  const stride = 2 * (components + components % 2), levels = 2 ** (name === 'POSITION' ? 14 : 12) - 1;
  const low = Array(components).fill(Infinity), high = Array(components).fill(-Infinity);
  values.forEach((value, i) => {
    low[i % components] = Math.min(low[i % components], value);
    high[i % components] = Math.max(high[i % components], value);
  });
  const scale = levels / (Math.max(...high.map((value, k) => value - low[k])) || 1), grid = new Uint16Array(count * stride / 2);
  values.forEach((value, i) => {
    grid[Math.floor(i / components) * stride / 2 + i % components] = Math.round((value - low[i % components]) * scale);
  });
  return { bytes: new Uint8Array(grid.buffer), stride };
}

