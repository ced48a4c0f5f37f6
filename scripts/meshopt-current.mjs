#!/usr/bin/env node
// Measures an asset with npm's meshoptimizer, where no current one is built (scripts/rivals measures built ones). To be compared with
// `gltf-psplit compare`, which uses the meshoptimizer that its build found:
//
//   scripts/meshopt-current.mjs ASSET [--psplit build/release/gltf-psplit] [--modules build/meshopt] [--repeat 9] [--json]
//
// npm's package is WASM. Its bytes equal those of any build. Its times are of WASM in Node.js, and must not be compared with
// native ones. The package is installed in --modules if it is not there yet. Meshes are prepared as
// tools/gltf_psplit/compare/meshopt_rival.h says: quantized with the bits that psplit takes by default (14, normals 10, texture
// coordinates and others 12, colours 8), each primitive on a grid of its own; equal points merged, triangles in strips, points in the
// order of use. zstd is Node.js' own or the command, at level 19; brotli is Node.js', at quality 11. The result is decoded and compared. An asset that is neither .gltf nor .glb is first converted, losslessly, by gltf-psplit.
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import zlib from 'node:zlib';

const kVersion = '1.3.0', kHighestLevel = 3, kZstdLevel = 19;
const kBits = { POSITION: 14, NORMAL: 10, TEXCOORD: 12, COLOR: 8 }, kOtherBits = 12;
const kNoPoint = 0xffffffff;

function fail(message) {
  console.error(`meshopt-current: ${message}`);
  process.exit(1);
}

let parsed;
try {
  parsed = parseArgs({
    allowPositionals: true,
    options: {
      psplit: { type: 'string', default: 'build/release/gltf-psplit' },
      modules: { type: 'string', default: 'build/meshopt' },
      repeat: { type: 'string', default: '9' },
      json: { type: 'boolean', default: false },
    },
  });
} catch (error) {
  fail(error.message);
}
const { values: options, positionals } = parsed;
const repeat = Number(options.repeat);
if (positionals.length !== 1 || !(repeat >= 1)) fail('usage: scripts/meshopt-current.mjs ASSET [options]');

async function load_package(folder) {
  const manifest = path.resolve(folder, 'node_modules/meshoptimizer/package.json');
  if (!existsSync(manifest))
    execFileSync('npm', ['install', '--prefix', folder, '--no-save', '--no-package-lock', '--no-audit', '--no-fund',
      '--loglevel=error', `meshoptimizer@${kVersion}`], { stdio: ['ignore', 'ignore', 'inherit'] });
  const { version } = JSON.parse(readFileSync(manifest, 'utf8'));
  const entry = createRequire(manifest).resolve(path.dirname(manifest));
  const { MeshoptEncoder, MeshoptDecoder } = await import(pathToFileURL(entry));
  await Promise.all([MeshoptEncoder.ready, MeshoptDecoder.ready]);
  return { version, encoder: MeshoptEncoder, decoder: MeshoptDecoder };
}

// The JSON and the buffers of a plain .gltf or .glb of the same mesh. Files that are read directly keep their order, which strips depend on.
function read_asset(asset) {
  const extension = path.extname(asset).toLowerCase();
  if (extension === '.gltf') {
    const json = JSON.parse(readFileSync(asset, 'utf8'));
    return { json, buffers: json.buffers.map(({ uri }) => (uri.startsWith('data:') ? Buffer.from(uri.slice(uri.indexOf(',') + 1), 'base64')
      : readFileSync(path.join(path.dirname(asset), decodeURIComponent(uri))))) };
  }
  const scratch = mkdtempSync(path.join(tmpdir(), 'psplit-meshopt-'));
  try {
    let glb = asset;
    if (extension !== '.glb') {
      const patches = path.join(scratch, 'patches.glb');
      glb = path.join(scratch, 'plain.glb');
      execFileSync(options.psplit, ['encode', '-q', '--lossless', asset, patches], { stdio: ['ignore', 'ignore', 'inherit'] });
      execFileSync(options.psplit, ['decode', '-q', patches, glb], { stdio: ['ignore', 'ignore', 'inherit'] });
    }
    const bytes = readFileSync(glb);
    if (bytes.length < 20 || bytes.toString('latin1', 0, 4) !== 'glTF') fail(`${asset} is not a GLB`);
    const json_bytes = bytes.readUInt32LE(12);
    return { json: JSON.parse(bytes.toString('utf8', 20, 20 + json_bytes)), buffers: [bytes.subarray(28 + json_bytes)] };
  } finally {
    rmSync(scratch, { recursive: true, force: true });
  }
}

const kComponents = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };
const kArrays = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };

// The values of an accessor, tightly packed.
function read_accessor({ json, buffers }, index) {
  const accessor = json.accessors[index], view = json.bufferViews[accessor.bufferView];
  const components = kComponents[accessor.type], Values = kArrays[accessor.componentType];
  if (!view || !components || accessor.sparse || view.extensions) fail(`accessor ${index} is of a kind that this script does not read`);
  const element_bytes = components * Values.BYTES_PER_ELEMENT, stride = view.byteStride ?? element_bytes;
  const bin = buffers[view.buffer], begin = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const packed = new Uint8Array(accessor.count * element_bytes);
  for (let i = 0; i < accessor.count; ++i)
    packed.set(bin.subarray(begin + i * stride, begin + i * stride + element_bytes), i * element_bytes);
  return { values: new Values(packed.buffer), components, count: accessor.count, is_float: accessor.componentType === 5126 };
}

// One grid for all components, in integers of 1 or 2 bytes. The stride is a multiple of 4 bytes.
function quantize_to_grid({ values, components, count }, bits) {
  const low = new Array(components).fill(Infinity), high = new Array(components).fill(-Infinity);
  values.forEach((value, i) => {
    low[i % components] = Math.min(low[i % components], value);
    high[i % components] = Math.max(high[i % components], value);
  });
  const range = Math.max(...high.map((value, i) => value - low[i])), scale = range > 0 ? ((1 << bits) - 1) / range : 0;
  const value_bytes = bits <= 8 ? 1 : 2, padded = Math.ceil(components * value_bytes / 4) * 4 / value_bytes;
  const grid = new (bits <= 8 ? Uint8Array : Uint16Array)(count * padded);
  values.forEach((value, i) => {
    grid[Math.floor(i / components) * padded + i % components] = Math.round((value - low[i % components]) * scale);
  });
  return { bytes: new Uint8Array(grid.buffer), stride: padded * value_bytes };
}

function pad_to_words({ values, components, count }) {
  const source = new Uint8Array(values.buffer), size = components * values.BYTES_PER_ELEMENT;
  const stride = Math.ceil(size / 4) * 4, bytes = new Uint8Array(count * stride);
  for (let i = 0; i < count; ++i) bytes.set(source.subarray(i * size, (i + 1) * size), i * stride);
  return { bytes, stride };
}

function quantize(name, attribute, encoder) {
  const { values, components, count, is_float } = attribute;
  if (!is_float || name.startsWith('_FEATURE_ID_') || name === '_BATCHID') return pad_to_words(attribute);
  const bits = kBits[name.split('_')[0]] ?? kOtherBits;
  if ((name !== 'NORMAL' || components !== 3) && (name !== 'TANGENT' || components !== 4)) return quantize_to_grid(attribute, bits);
  const vectors = new Float32Array(count * 4), stride = bits <= 8 ? 4 : 8;
  values.forEach((value, i) => { vectors[Math.floor(i / components) * 4 + i % components] = value; });
  return { bytes: encoder.encodeFilterOct(vectors, count, stride, bits), stride, filter: 'OCTAHEDRAL' };
}

function move_points(streams, remap, kept) {
  return streams.map((stream) => {
    const bytes = new Uint8Array(kept * stream.stride);
    remap.forEach((target, point) => {
      if (target !== kNoPoint)
        bytes.set(stream.bytes.subarray(point * stream.stride, (point + 1) * stream.stride), target * stream.stride);
    });
    return { ...stream, bytes };
  });
}

// Points that are equal in all streams become one.
function merge_points(streams, indices, count) {
  const first = new Map(), remap = new Uint32Array(count);
  for (let point = 0; point < count; ++point) {
    const key = streams.map(({ bytes, stride }) =>
      Buffer.from(bytes.buffer, bytes.byteOffset + point * stride, stride).toString('latin1')).join('');
    if (!first.has(key)) first.set(key, first.size);
    remap[point] = first.get(key);
  }
  return { streams: move_points(streams, remap, first.size), indices: indices.map((point) => remap[point]), count: first.size };
}

function prepare(asset, primitive, encoder) {
  let streams = Object.entries(primitive.attributes).map(([name, index]) => quantize(name, read_accessor(asset, index), encoder));
  const count = asset.json.accessors[primitive.attributes.POSITION].count;
  const indices = primitive.indices === undefined ? Uint32Array.from({ length: count }, (_, i) => i)
    : Uint32Array.from(read_accessor(asset, primitive.indices).values);
  const merged = merge_points(streams, indices, count);
  const [remap, kept] = encoder.reorderMesh(merged.indices, true, true);
  return { indices: merged.indices, count: kept, streams: move_points(merged.streams, remap, kept) };
}

function zstd(bytes) {
  if (zlib.zstdCompressSync)
    return zlib.zstdCompressSync(bytes, { params: { [zlib.constants.ZSTD_c_compressionLevel]: kZstdLevel } });
  const run = spawnSync('zstd', [`-${kZstdLevel}`, '--no-check', '-c', '-q'], { input: bytes, maxBuffer: 2 ** 31 - 1 });
  if (run.error || run.status !== 0) fail('zstd is missing: neither this Node.js nor the system has it');
  return run.stdout;
}

function encode(mesh, encoder, codec) {
  const indices = encoder.encodeIndexBuffer(new Uint8Array(mesh.indices.buffer), mesh.indices.length, 4);
  const streams = mesh.streams.map(({ bytes, stride }) => encoder.encodeVertexBufferLevel(bytes, mesh.count, stride, kHighestLevel, codec));
  const packed = Buffer.concat([indices, ...streams]);
  return { indices, streams, packed_bytes: packed.length, zstd_bytes: zstd(packed).length, brotli_bytes: zlib.brotliCompressSync(packed).length };
}

function decode(mesh, encoded, decoder, with_filters) {
  const indices = new Uint32Array(mesh.indices.length);
  decoder.decodeIndexBuffer(new Uint8Array(indices.buffer), mesh.indices.length, 4, encoded.indices);
  const streams = mesh.streams.map(({ stride, filter }, i) => {
    const bytes = new Uint8Array(mesh.count * stride);
    decoder.decodeVertexBuffer(bytes, mesh.count, stride, encoded.streams[i], with_filters ? filter : undefined);
    return bytes;
  });
  return { indices, streams };
}

// The codec may start a triangle at another corner.
function same_triangles(a, b) {
  for (let i = 0; i < a.length; i += 3) {
    const turned = [0, 1, 2].some((k) => a[i] === b[i + k] && a[i + 1] === b[i + (k + 1) % 3] && a[i + 2] === b[i + (k + 2) % 3]);
    if (!turned) return false;
  }
  return a.length === b.length;
}

function check(mesh, encoded, decoder) {
  const decoded = decode(mesh, encoded, decoder, false);
  if (!same_triangles(mesh.indices, decoded.indices)) fail('the decoded triangles are not those that were encoded');
  decoded.streams.forEach((bytes, i) => {
    if (Buffer.compare(bytes, mesh.streams[i].bytes) !== 0) fail('the decoded points are not those that were encoded');
  });
}

const [asset] = positionals;
const { version, encoder, decoder } = await load_package(options.modules);
const document = read_asset(asset);
const primitives = (document.json.meshes ?? []).flatMap((mesh) => mesh.primitives).filter(({ mode }) => (mode ?? 4) === 4);
if (primitives.length === 0) fail(`${asset} holds no triangles`);
for (const { extensions } of primitives)
  if (Object.keys(extensions ?? {}).some((name) => name.includes('draco'))) fail(`${asset} is compressed: decode it first`);
const meshes = primitives.map((primitive) => prepare(document, primitive, encoder));
const sum = (list, value) => list.reduce((total, item) => total + value(item), 0);

const rows = [0, 1].map((codec) => {
  const encoded = meshes.map((mesh) => encode(mesh, encoder, codec));
  meshes.forEach((mesh, i) => check(mesh, encoded[i], decoder));
  const times = [];
  for (let round = 0; round <= repeat; ++round) {
    const begin = performance.now();
    meshes.forEach((mesh, i) => decode(mesh, encoded[i], decoder, true));
    if (round > 0) times.push(performance.now() - begin);
  }
  times.sort((a, b) => a - b);
  return {
    meshoptimizer: version, codec, bytes: sum(encoded, (mesh) => mesh.packed_bytes),
    zstd_bytes: sum(encoded, (mesh) => mesh.zstd_bytes), brotli_bytes: sum(encoded, (mesh) => mesh.brotli_bytes),
    wasm_decode_ms: times[times.length >> 1],
  };
});
const faces = sum(meshes, (mesh) => mesh.indices.length / 3), points = sum(meshes, (mesh) => mesh.count);
if (options.json) {
  console.log(JSON.stringify({ input: path.basename(asset), faces, points, rows }, null, 2));
} else {
  const number = (value) => value.toLocaleString('en-US');
  console.log(`${path.basename(asset)}: ${number(faces)} faces, ${number(points)} points after merging, in ${meshes.length} meshes\n`);
  console.log('| meshoptimizer | codec of attributes | bytes | with zstd 19 | with brotli 11 | decoding in WASM alone |\n|---|---|---|---|---|---|');
  for (const row of rows)
    console.log(`| ${row.meshoptimizer} | ${row.codec} | ${number(row.bytes)} | ${number(row.zstd_bytes)} | ${number(row.brotli_bytes)} | ${row.wasm_decode_ms.toFixed(1)} ms |`);
}
