// psplit/encode: its containers equal the command's, byte for byte, and decode to the mesh; workers, errors, and a page.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { page_test } from './browser.mjs';
import { compressed_primitives, corpus_folder, files_below, gltf_psplit, package_folder, psplit, random_numbers, stock } from './load.mjs';

const import_package = (name) => import(pathToFileURL(path.join(package_folder, name)));
const { PsplitError, configure, createEncoder, encodeMesh, encodeMeshes, encodePoints } = await import_package('encode.js');
const { decodeGlb } = await import_package('asset.js');
const folder = mkdtempSync(path.join(tmpdir(), 'psplit-encode-'));
after(() => rmSync(folder, { recursive: true }));
const file = (name) => path.join(folder, name);
const needs_tool = { skip: gltf_psplit === null && 'there is no gltf-psplit' };
const native = (...of) => execFileSync(gltf_psplit, of.map(String), { stdio: ['ignore', 'pipe', 'pipe'] });
const text_of = (bytes) => Buffer.from(bytes).toString('base64');

// A grid of size x size squares that is bent, with normals, texture coordinates and weights of two bones.
function bent_grid(size, wave = 0.2) {
  const positions = [], normals = [], texcoords = [], weights = [], joints = [], indices = [], side = size + 1;
  for (let y = 0; y < side; ++y)
    for (let x = 0; x < side; ++x) {
      const slope = 7 * wave * Math.cos(7 * x / size), length = Math.hypot(slope, 1);
      positions.push(x / size, wave * Math.sin(7 * x / size), y / size);
      normals.push(-slope / length, 1 / length, 0);
      texcoords.push(x / size, y / size);
      weights.push(x / size, 1 - x / size, 0, 0);
      joints.push(0, 1, 0, 0);
      if (x === size || y === size) continue;
      const at = y * side + x;
      indices.push(at, at + side, at + 1, at + 1, at + side, at + side + 1);
    }
  const floats = (array, componentCount) => ({ array: Float32Array.from(array), componentCount });
  return { indices: Uint32Array.from(indices), attributes: { POSITION: floats(positions, 3), NORMAL: floats(normals, 3), TEXCOORD_0: floats(texcoords, 2),
    JOINTS_0: { array: Uint8Array.from(joints), componentCount: 4 }, WEIGHTS_0: floats(weights, 4) } };
}

// What the command calls the options.
const kFlags = { patches: '--patches', patchFaces: '--patch-faces', minFaces: '--min-faces', profile: '--profile', positionBits: '--quantize-position',
  normalBits: '--quantize-normal', texcoordBits: '--quantize-texcoord', colorBits: '--quantize-color', genericBits: '--quantize-generic', maxError: '--max-error',
  lossless: '--lossless', encodeSpeed: '--encode-speed', condense: '--condense', boxes: '--boxes', order: '--order', keepDuplicates: '--keep-duplicates',
  keepDegenerate: '--keep-degenerate', keepUnused: '--keep-unused', verify: '--no-verify' };
const flags_of = (options) => Object.entries(options).flatMap(([name, value]) =>
  (typeof value === 'boolean' ? [kFlags[name]] : [kFlags[name], value.near ? `near:${value.near}` : value]));
const stored_of = (asset) => compressed_primitives(asset, 'PSPLIT_mesh_draco_patches').map(({ bytes }) => text_of(bytes));

// Compares with the command, on one thread and on two. Returns the meshes.
async function same_as_command(asset, options, message = JSON.stringify(options)) {
  const { primitives } = await decodeGlb(readFileSync(asset));
  // The command leaves what cannot be encoded.
  const made = await encodeMeshes(primitives, { ...options, grids: primitives.map(({ mesh }) => mesh) }).catch((error) => {
    assert.equal(error.code, 'unsupported', message);
    return [];
  });
  for (const threads of [1, 2]) {
    native('encode', '-q', '--always-patches', '-j', threads, ...flags_of(options), asset, file('patches.glb'));
    assert.deepEqual(made.map(({ container }) => text_of(container)), stored_of(file('patches.glb')), message);
  }
  return made;
}

for (const [shape, faces, more, all_options] of [
  ['blob', 45000, [], [{}, { condense: true }, { positionBits: 'auto' }, { maxError: 0.0001, boxes: true }]],
  ['gyroid', 30000, ['--normals'], [{}, { profile: 'speed', condense: true }, { encodeSpeed: 0, patchFaces: 900 }, { lossless: true }]],
  ['terrain', 25000, ['--normals', '--texcoords'], [{ profile: 'size', condense: true }, { profile: 'size' }, { encodeSpeed: 10, patches: 9, order: 'size' },
    { positionBits: 11, normalBits: 8, texcoordBits: 10, verify: false, order: { near: [0.5, 1, -2] }, patchFaces: 2000 },
    { keepDuplicates: true, keepDegenerate: true, keepUnused: true, minFaces: 30000 }]],
  ['scene', 30000, ['--normals'], [{}, { patches: 20, condense: true }, { profile: 'speed', boxes: true }]],
])
  test(`${shape}: the bytes of the command`, needs_tool, async () => {
    native('generate', '-q', file(`${shape}.glb`), '--shape', shape, '--faces', faces, ...more);
    for (const options of all_options) await same_as_command(file(`${shape}.glb`), options);
  });

test('meshes of the corpus: the bytes of the command', { skip: needs_tool.skip || (corpus_folder === null && 'there is no corpus'), timeout: 600000 }, async () => {
  let count = 0;
  for (const [i, source] of files_below(path.join(corpus_folder, 'mesh'), /\.(ply|obj|stl|off)(\.gz|\.zst)?$/i).entries()) {
    if (i % 6 !== 0) continue;
    try {
      native('encode', '-q', '--lossless', source, file('new.glb'));
      native('decode', '-q', file('new.glb'), file('plain.glb'));
    } catch {
      continue;  // no mesh, or one that is malformed
    }
    const plain = readFileSync(file('plain.glb'));
    if (plain.length > 2_000_000) continue;
    const { primitives } = await decodeGlb(plain);
    if (!primitives.every(({ mode, indices }) => mode === 4 && indices?.length > 0)) continue;
    await same_as_command(file('plain.glb'), count % 2 === 0 ? { patchFaces: 1000 } : { condense: true }, source);
    ++count;
  }
  assert.ok(count >= 10, `${count} meshes`);
});

test('skinned meshes, degenerate faces and unused points: the bytes of the command', needs_tool, async () => {
  const random = random_numbers(5), mesh = bent_grid(60);
  for (let i = 0; i < 40; ++i) mesh.indices[3 * random(mesh.indices.length / 3)] = mesh.indices[3 * random(mesh.indices.length / 3)];
  const used = new Set(mesh.indices);
  mesh.indices = mesh.indices.map((point) => (point === 77 ? 78 : point));
  assert.ok(used.has(77));
  const arrays = [mesh.indices, ...Object.values(mesh.attributes).map(({ array }) => array)], names = Object.keys(mesh.attributes);
  const bytes = Buffer.concat(arrays.map((array) => Buffer.from(array.buffer)));
  let at = 0;
  const views = arrays.map((array) => ({ buffer: 0, byteOffset: (at += array.byteLength) - array.byteLength, byteLength: array.byteLength }));
  const count = mesh.attributes.POSITION.array.length / 3, kinds = { 2: 'VEC2', 3: 'VEC3', 4: 'VEC4' };
  const json = { asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    buffers: [{ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString('base64')}` }], bufferViews: views,
    accessors: [{ bufferView: 0, componentType: 5125, count: mesh.indices.length, type: 'SCALAR' }, ...names.map((name, i) => ({ bufferView: 1 + i,
      componentType: name === 'JOINTS_0' ? 5121 : 5126, count, type: kinds[mesh.attributes[name].componentCount],
      ...(name === 'POSITION' && { min: [0, 1, 2].map((c) => Math.min(...mesh.attributes.POSITION.array.filter((_, k) => k % 3 === c))),
        max: [0, 1, 2].map((c) => Math.max(...mesh.attributes.POSITION.array.filter((_, k) => k % 3 === c))) }) }))],
    meshes: [{ primitives: [{ indices: 0, attributes: Object.fromEntries(names.map((name, i) => [name, 1 + i])) }] }] };
  const { writeFileSync } = await import('node:fs');
  writeFileSync(file('skinned.gltf'), JSON.stringify(json));
  for (const options of [{}, { keepDegenerate: true, keepUnused: true }, { condense: true, keepUnused: true, patches: 3 }])
    await same_as_command(file('skinned.gltf'), options);
});

// The largest distance of positions from where they were.
function distance(mesh, { attributes, sourcePoints }) {
  const { array } = attributes.find(({ name }) => name === 'POSITION'), before = mesh.attributes.POSITION.array;
  let largest = 0;
  sourcePoints.forEach((source, point) => {
    largest = Math.max(largest, Math.hypot(...[0, 1, 2].map((c) => array[3 * point + c] - before[3 * source + c])));
  });
  return largest;
}
test('containers decode to the mesh', async () => {
  const mesh = bent_grid(50);
  for (const options of [{}, { patchFaces: 700, condense: true }, { lossless: true, patches: 4 }]) {
    const made = await encodeMesh(mesh, { ...options, decoded: true });
    const decoded = await psplit.decodeContainer(made.container, { attributes: made.attributes.map(({ name, uniqueId, type, componentCount, normalized }) =>
      ({ name, uniqueId, type, componentCount, normalized })) });
    assert.deepEqual([decoded.faceCount, decoded.pointCount, decoded.patchCount, decoded.hasResidue, decoded.isCondensed],
      [made.faceCount, made.pointCount, made.patchCount, made.hasResidue, options.condense === true]);
    assert.deepEqual(decoded.indices, made.indices);
    for (const [i, { array }] of decoded.attributes.entries()) assert.deepEqual(array, made.attributes[i].array);
    assert.ok(Math.abs(distance(mesh, made) - made.positionError) < 1e-9, `${distance(mesh, made)} ${made.positionError}`);
    assert.equal(made.positionError === 0, options.lossless === true);
    assert.deepEqual([...new Set(made.sourcePoints)].length, 51 * 51);
    assert.equal(made.faceCount, 5000);
    // A face by its points of the mesh.
    const faces = (indices) => Array.from({ length: indices.length / 3 }, (_, i) => indices.slice(3 * i, 3 * i + 3))
      .map((face) => [0, 1, 2].map((k) => [face[k], face[(k + 1) % 3], face[(k + 2) % 3]].join()).sort()[0]).sort();
    assert.deepEqual(faces(Array.from(made.indices, (point) => made.sourcePoints[point])), faces(Array.from(mesh.indices)));
    const { arrays } = { arrays: await encodeMesh(mesh, options) };
    assert.equal(arrays.indices, undefined);
    assert.equal(arrays.attributes[0].array, undefined);
  }
});

test('meshes as three has them, without indices, and with data that keeps points apart', async () => {
  const { indices, attributes } = bent_grid(8), soup = Float32Array.from([...indices].flatMap((point) => [...attributes.POSITION.array.subarray(3 * point, 3 * point + 3)]));
  const made = await encodeMesh({ attributes: { POSITION: { array: soup, itemSize: 3 } } });
  assert.deepEqual([made.faceCount, made.pointCount, made.mergedPoints], [128, 81, 3 * 128 - 81]);
  const distinct = Uint32Array.from({ length: 3 * 128 }, (_, i) => i);
  assert.equal((await encodeMesh({ attributes: { POSITION: { array: soup, itemSize: 3 } }, distinct })).pointCount, 3 * 128);
  const clamped = { array: new Uint8ClampedArray(4 * 81).fill(200), componentCount: 4, normalized: true };
  const { attributes: [, color] } = await encodeMesh({ indices, attributes: { POSITION: attributes.POSITION, COLOR_0: clamped } });
  assert.deepEqual([color.name, color.type, color.normalized, color.bits], ['COLOR_0', 'uint8', true, 0]);
});

test('values that no grid holds are kept exactly', async () => {
  const mesh = bent_grid(10);
  mesh.attributes.POSITION.array.set([NaN, Infinity, -0], 30);
  const made = await encodeMesh(mesh, { decoded: true }), position = made.attributes[0];
  assert.equal(position.bits, 0);
  const bits = (array) => new Uint32Array(Float32Array.from(array).buffer);
  made.sourcePoints.forEach((source, point) => assert.deepEqual(bits(position.array.subarray(3 * point, 3 * point + 3)),
    bits(mesh.attributes.POSITION.array.subarray(3 * source, 3 * source + 3))));
  assert.equal((await encodeMesh(bent_grid(10), { exact: ['TEXCOORD_0'] })).attributes.find(({ name }) => name === 'TEXCOORD_0').bits, 0);
});

const triangle = { array: Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0]), componentCount: 3 };
const kBadMeshes = [
  [null, /no attributes/], [{ indices: new Uint16Array(3) }, /no attributes/], [{ attributes: { NORMAL: triangle } }, /no POSITION/],
  [{ attributes: { POSITION: { array: [0, 1, 2], componentCount: 3 } } }, /POSITION has no array of a type that glTF has/],
  [{ attributes: { POSITION: { array: new Float64Array(9), componentCount: 3 } } }, /POSITION has no array of a type/],
  [{ attributes: { POSITION: { array: triangle.array } } }, /no component count/],
  [{ attributes: { POSITION: { array: new Float32Array(17), componentCount: 17 } } }, /no component count from 1 to 16/],
  [{ attributes: { POSITION: { array: new Float32Array(8), componentCount: 3 } } }, /no whole number of points/],
  [{ attributes: { POSITION: triangle, NORMAL: { array: new Float32Array(6), componentCount: 3 } } }, /NORMAL has 2 points, but POSITION has 3/],
  [{ indices: [0, 1, 2], attributes: { POSITION: triangle } }, /the indices are neither/],
  [{ indices: new Uint8Array(4), attributes: { POSITION: triangle } }, /not whole faces/],
  [{ indices: Uint32Array.of(0, 1, 3), attributes: { POSITION: triangle } }, /an index is 3, but there are 3 points/],
  [{ indices: Uint32Array.of(0, 1, 0xffffffff), attributes: { POSITION: triangle } }, /an index is 4294967295, but/],
  [{ indices: new Uint32Array(), attributes: { POSITION: triangle } }, /no triangles/],
  [{ attributes: { POSITION: { array: new Float32Array(), componentCount: 3 } } }, /no triangles/],
  [{ indices: Uint8Array.of(0, 1, 1), attributes: { POSITION: triangle } }, /no triangles but degenerate ones/, 'unsupported'],
  [{ attributes: { POSITION: triangle, _ID: { array: new Uint32Array(3), componentCount: 1 } } }, /_ID holds 32-bit integers/, 'unsupported'],
  [{ attributes: { POSITION: triangle }, distinct: new Uint8Array(4) }, /not as many for each point/],
];
const kBadOptions = [[{ positionBits: 31 }, /`positionBits` cannot be 31/], [{ positionBits: 0 }, /positionBits/], [{ normalBits: 1 }, /normalBits/],
  [{ encodeSpeed: 11 }, /encodeSpeed/], [{ profile: 'fast' }, /`profile` cannot be fast/], [{ order: { near: [0, 1] } }, /order/],
  [{ patches: 2, patchFaces: 3 }, /exclude each other/], [{ maxError: 1, positionBits: 12 }, /exclude each other/], [{ patches: 1.5 }, /patches/],
  [{ condense: 1 }, /condense/], [{ speed: 5 }, /there is no option `speed`/], [{ nearX: 5 }, /there is no option `nearX`/], [{ exact: 'POSITION' }, /exact/],
  [{ onProgress: 1 }, /onProgress/], [{ signal: 1 }, /signal/], [{ maxError: 1e-12 }, /cannot be guaranteed: floats of these coordinates allow no less than 8\.27e-7/]];
test('bad input is refused with a code', async () => {
  const encoder = createEncoder();
  for (const encode of [encodeMesh, (...of) => encoder.encodeMesh(...of)]) {
    for (const [mesh, message, code = 'invalid-input'] of kBadMeshes)
      await assert.rejects(encode(mesh), (error) => error instanceof PsplitError && error.code === code && message.test(error.message), String(message));
    for (const [options, message] of kBadOptions)
      await assert.rejects(encode({ attributes: { POSITION: triangle } }, options), (error) => error instanceof PsplitError && error.code === 'invalid-input' &&
        message.test(error.message), String(message));
    assert.equal((await encode({ attributes: { POSITION: triangle } })).faceCount, 1);
  }
  encoder.dispose();
  const mesh = { attributes: { POSITION: triangle } };
  await assert.rejects(encodeMeshes([mesh, { ...mesh, indices: Uint32Array.of(0, 1, 3) }]), /mesh 1: an index is 3/);
  await assert.rejects(encodeMeshes([]), /no meshes/);
  await assert.rejects(encodeMeshes([mesh], { grids: [] }), /grids/);
});

test('a worker encodes: the same bytes, progress, transfer and abort', async () => {
  const mesh = bent_grid(120), here = [], there = [], encoder = createEncoder();
  const expected = await encodeMesh(mesh, { patchFaces: 3000, onProgress: (...counts) => here.push(counts) });
  const made = await encoder.encodeMesh(mesh, { patchFaces: 3000, onProgress: (...counts) => there.push(counts) });
  assert.deepEqual(made, expected);
  assert.deepEqual(there, here);
  assert.ok(here.length >= 10 && here.every(([done, total], i) => total === 28800 && done > (here[i - 1]?.[0] ?? 0)), JSON.stringify(here));
  assert.deepEqual(here.at(-1), [28800, 28800]);
  assert.equal(mesh.indices.length, 3 * 28800, 'the worker had a copy');

  // An abort ends the job at once, and the next one is done.
  const stop = new AbortController();
  await assert.rejects(encoder.encodeMesh(mesh, { patchFaces: 100, signal: stop.signal, onProgress: () => stop.abort() }), { code: 'aborted' });
  await assert.rejects(encoder.encodeMesh(mesh, { signal: stop.signal }), { code: 'aborted' });
  await assert.rejects(encodeMesh(mesh, { signal: stop.signal }), { code: 'aborted' });
  // The calling thread is busy, but its own function may abort.
  const own = new AbortController();
  let calls = 0;
  await assert.rejects(encodeMesh(mesh, { patchFaces: 100, signal: own.signal, onProgress: () => (++calls === 2 && own.abort()) }), { code: 'aborted' });
  assert.equal(calls, 2);
  await assert.rejects(encoder.encodeMesh(mesh, { onProgress: () => { throw new Error('of the caller'); } }), { message: 'of the caller' });
  assert.deepEqual(await encoder.encodeMesh(mesh, { patchFaces: 3000, transfer: true }), expected);
  assert.equal(mesh.indices.length, 0, 'the worker took the array');
  const waiting = encoder.encodeMesh(bent_grid(20));
  encoder.dispose();
  await assert.rejects(waiting, { code: 'aborted' });
  await assert.rejects(encoder.encodeMesh(bent_grid(20)), { code: 'aborted' });
});

test('a module that is missing, or another one', async () => {
  configure({ wasm: pathToFileURL(path.join(package_folder, 'psplit.wasm')) });
  await assert.rejects(encodeMesh(bent_grid(3)), { code: 'failed', message: 'the WebAssembly module is not psplit_encoder.wasm' });
  configure({ wasm: pathToFileURL(path.join(package_folder, 'nothing.wasm')) });
  await assert.rejects(encodeMesh(bent_grid(3)), { code: 'failed', message: /nothing\.wasm cannot be loaded/ });
  configure({});
  assert.equal((await encodeMesh(bent_grid(3))).faceCount, 18);
});

const grid_of_page = bent_grid(60), digest = (array) => createHash('sha256').update(array).digest('hex');
page_test('a page encodes in a worker', { headers: { 'Content-Security-Policy': "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'" },
  argument: { indices: [...grid_of_page.indices], positions: [...grid_of_page.attributes.POSITION.array] },
  script: async ({ indices, positions }) => {
    const { createEncoder } = await import('/psplit/encode.js'), { decodeContainer } = await import('/psplit/index.js'), { digest } = await import('/page.js');
    const encoder = createEncoder({ mainThread: false }), progress = [];
    const mesh = { indices: Uint32Array.from(indices), attributes: { POSITION: { array: Float32Array.from(positions), componentCount: 3 } } };
    const { container, faceCount } = await encoder.encodeMesh(mesh, { patchFaces: 1000, onProgress: (done) => progress.push(done) });
    const decoded = await decodeContainer(container);
    encoder.dispose();
    return { digest: await digest(container), faceCount, decoded: decoded.faceCount, progress };
  } }, async ({ result, site }) => {
  const { POSITION } = grid_of_page.attributes;
  const { container } = await encodeMesh({ indices: grid_of_page.indices, attributes: { POSITION } }, { patchFaces: 1000 });
  const { digest: of_page, faceCount, decoded, progress } = await result;
  assert.equal(of_page, digest(container));
  assert.deepEqual([faceCount, decoded, progress.at(-1)], [7200, 7200, 7200]);
  assert.ok(progress.length >= 7);
  assert.ok(site.requests.includes('/psplit/encode_worker.js'));
});

// draco3d's stream of the same points, with the same bits.
function stock_cloud(draco, { attributes }, bits, speed) {
  const builder = new draco.PointCloudBuilder(), cloud = new draco.PointCloud(), encoder = new draco.Encoder(), out = new draco.DracoInt8Array();
  const semantics = { POSITION: draco.POSITION, NORMAL: draco.NORMAL, COLOR_0: draco.COLOR };
  for (const [name, { array, componentCount }] of Object.entries(attributes))
    builder[array instanceof Float32Array ? 'AddFloatAttribute' : 'AddUInt8Attribute'](cloud, semantics[name], array.length / componentCount, componentCount, array);
  Object.entries(bits).forEach(([name, count]) => encoder.SetAttributeQuantization(semantics[name], count));
  encoder.SetSpeedOptions(speed, speed);
  return Uint8Array.from({ length: encoder.EncodePointCloudToDracoBuffer(cloud, false, out) }, (_, i) => out.GetValue(i));
}

test('point clouds have the bytes of draco3d, and their points are where they are said to be', async () => {
  const draco = await stock.createEncoderModule({}), { attributes } = bent_grid(20), points = attributes.POSITION.array.length / 3;
  const cloud = { attributes: { POSITION: attributes.POSITION, NORMAL: attributes.NORMAL,
    COLOR_0: { array: Uint8Array.from({ length: 4 * points }, (_, i) => (i * 37) % 256), componentCount: 4 } } };
  const encoder = createEncoder();
  for (const encodeSpeed of [0, 5, 9, 10])
    for (const lossless of [false, true]) {
      const options = lossless ? { encodeSpeed, lossless } : { encodeSpeed, positionBits: 11, normalBits: 9 };
      const made = await encodePoints(cloud, { ...options, decoded: true });
      assert.deepEqual(made.stream, stock_cloud(draco, cloud, lossless ? {} : { POSITION: 11, NORMAL: 9 }, encodeSpeed), JSON.stringify(options));
      assert.deepEqual((await encoder.encodePoints(cloud, options)).stream, made.stream);
      assert.deepEqual([...made.sourcePoints].sort((a, b) => a - b), Array.from({ length: points }, (_, i) => i));
      const is_tree = made.stream[8] === 1, [position, , color] = made.attributes;
      assert.equal(is_tree, !lossless && encodeSpeed < 10);
      made.sourcePoints.forEach((source, i) => {
        for (let k = 0; k < 4; ++k) assert.equal(color.array[4 * i + k], cloud.attributes.COLOR_0.array[4 * source + k]);
        for (let k = 0; k < 3; ++k)
          assert.ok(Math.abs(position.array[3 * i + k] - attributes.POSITION.array[3 * source + k]) <= (lossless ? 0 : 1e-3));
      });
      assert.ok(made.positionError <= 1e-3);
    }
  encoder.dispose();
  await assert.rejects(encodePoints({ ...cloud, indices: Uint32Array.of(0, 1, 2) }), /neither indices/);
  await assert.rejects(encodePoints({ attributes: { POSITION: { array: new Float32Array(0), componentCount: 3 } } }), /no points/);
  await assert.rejects(encodePoints(cloud, { positionBits: 'auto' }), /no edges/);
});
