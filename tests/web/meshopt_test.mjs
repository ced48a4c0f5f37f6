// Assets of `encode --meshopt` in real loaders, with psplit's decoder and meshoptimizer's: three's GLTFLoader and Babylon.js, in
// Node.js and in Chromium. Points, faces, morph targets, skins and animations are the original's, within what the manual states.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { page_test } from './browser.mjs';
import { character_differences, counts_of, of_babylon, of_three } from './compare_characters.mjs';
import { corpus_folder, gltf_psplit, modules_folder, package_folder, psplit, read_asset, root } from './load.mjs';
import { make_glb } from './stock_draco.mjs';
import { buffer_of, make_loader, MeshoptDecoder, PsplitDracoLoader } from './three_loaders.mjs';

const skip = gltf_psplit === null && 'there is no gltf-psplit';
const folder = path.join(root, 'build/web/meshopt');

// A bent bar of two bones with three morph targets, one of them zero, beside a cloud of points; with animations of all paths.
function make_character() {
  const json = { asset: { version: '2.0' }, buffers: [{}], bufferViews: [], accessors: [], scene: 0, scenes: [{ nodes: [0, 1, 4] }],
    nodes: [{ name: 'bar', mesh: 0, skin: 0 }, { name: 'hip', children: [2] }, { name: 'knee', translation: [0, 1, 0] }, { name: 'unused' },
      { name: 'cloud', mesh: 1, translation: [2, 0, 0] }], skins: [{ joints: [1, 2] }], meshes: [], animations: [{ name: 'move', channels: [], samplers: [] }] };
  let bytes = Buffer.alloc(0);
  const kTypes = { Float32Array: 5126, Uint16Array: 5123, Uint8Array: 5121 }, kShapes = { 1: 'SCALAR', 2: 'VEC2', 3: 'VEC3', 4: 'VEC4', 16: 'MAT4' };
  const add = (array, size, has_bounds = false) => {
    json.bufferViews.push({ buffer: 0, byteOffset: bytes.length, byteLength: array.byteLength });
    bytes = Buffer.concat([bytes, Buffer.from(array.buffer), Buffer.alloc(-array.byteLength & 3)]);
    const bound = (of) => Array.from({ length: size }, (_, c) => of(...array.filter((_, i) => i % size === c)));
    return json.accessors.push({ bufferView: json.bufferViews.length - 1, componentType: kTypes[array.constructor.name], type: kShapes[size],
      count: array.length / size, ...(has_bounds && { min: bound(Math.min), max: bound(Math.max) }) }) - 1;
  };
  const kColumns = 16, kRows = 24, points = [], faces = [];
  for (let r = 0; r <= kRows; ++r) for (let c = 0; c <= kColumns; ++c) points.push([c / kColumns * 2 * Math.PI, 2 * r / kRows]);
  for (let r = 0; r < kRows; ++r) for (let c = 0; c < kColumns; ++c) {
    const at = r * (kColumns + 1) + c;
    faces.push(at, at + 1, at + kColumns + 1, at + 1, at + kColumns + 2, at + kColumns + 1);
  }
  const of_points = (value) => Float32Array.from(points.flatMap(value));
  const is_upper = ([, y]) => Number(y > 1);
  json.meshes.push({ primitives: [{ indices: add(Uint16Array.from(faces), 1), attributes: {
    POSITION: add(of_points(([a, y]) => [0.3 * Math.cos(a), y, 0.3 * Math.sin(a)]), 3, true), NORMAL: add(of_points(([a]) => [Math.cos(a), 0, Math.sin(a)]), 3),
    JOINTS_0: add(Uint8Array.from(points.flatMap((point) => [is_upper(point), 0, 0, 0])), 4), WEIGHTS_0: add(of_points(() => [1, 0, 0, 0]), 4) },
  targets: [[([a, y]) => [0.1 * Math.cos(a) * Math.sin(3 * y), 0, 0], ([a, y]) => [0, 0.2 * Math.cos(a + y), 0]], [() => [0, 0, 0], () => [0, 0, 0]],
    [(point) => [0, is_upper(point) * point[1] / 7, 0], () => [0, 0, 0]]].map(([position, normal]) =>
    ({ POSITION: add(of_points(position), 3, true), NORMAL: add(of_points(normal), 3) })) }] });
  const cloud = Float32Array.from({ length: 3 * 400 }, (_, i) => Math.sin(i * i % 1009));
  json.meshes.push({ primitives: [{ mode: 0, attributes: { POSITION: add(cloud, 3, true) } }] });
  json.skins[0].inverseBindMatrices = add(Float32Array.from([0, -1].flatMap((y) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, y, 0, 1])), 16);
  const times = Float32Array.from({ length: 60 }, (_, i) => i / 24 + (i % 7) / 1000), input = add(times, 1, true), [{ channels, samplers }] = json.animations;
  const animate = (node, target_path, size, value) => {
    channels.push({ sampler: samplers.push({ input, output: add(Float32Array.from([...times].flatMap(value)), size) }) - 1, target: { node, path: target_path } });
  };
  animate(2, 'rotation', 4, (t) => [Math.sin(t / 2), 0, 0, Math.cos(t / 2)]);
  animate(1, 'translation', 3, (t) => [t / 3, Math.sin(t), 0.001 * t]);
  animate(4, 'scale', 3, (t) => [1 + t / 9, 1, 2 - Math.cos(t)]);
  animate(0, 'weights', 1, (t) => [Math.sin(t) ** 2, 0, t / 3]);
  json.buffers[0].byteLength = bytes.length;
  return make_glb(json, bytes);
}

// Names of assets in /NAME/, and what they are encoded with. Babylon.js does not know KHR_meshopt_compression.
const kVariants = { meshopt: ['--meshopt'], condensed: ['--condense', '--meshopt'], khr: ['--meshopt=khr'], 'condensed-khr': ['--condense', '--meshopt=khr'] };
const for_babylon = (variant) => !variant.includes('khr');
// Images need a page that draws.
const kBabylonOptions = { pluginExtension: '.glb', pluginOptions: { gltf: { skipMaterials: true } } };
const file = (name, variant) => path.join(folder, `${name}.${variant}.glb`);
const names = [];
if (skip === false) {
  mkdirSync(folder, { recursive: true });
  writeFileSync(file('made', 'original'), make_character());
  names.push('made');
  if (corpus_folder !== null)
    for (const asset of ['mor/RobotExpressive.glb', 'mor/Horse.glb', 'mor/rpm_avatar.glb', 'draco/CesiumMan.glb', 'bjs/morphLoader.glb']) {
      const name = path.basename(asset, '.glb');
      writeFileSync(file(name, 'original'), readFileSync(path.join(corpus_folder, 'gltf', asset)));
      names.push(name);
    }
  for (const name of names)
    for (const [variant, options] of Object.entries(kVariants))
      execFileSync(gltf_psplit, ['encode', '-q', file(name, 'original'), file(name, variant), ...options]);
}
const all = (chosen = () => true) => names.flatMap((name) => Object.keys(kVariants).filter(chosen).map((variant) => [name, variant]));

function assert_extensions(name, variant) {
  const { json: { extensionsRequired } } = read_asset(file(name, variant));
  assert.equal(extensionsRequired.includes(`${variant.includes('khr') ? 'KHR' : 'EXT'}_meshopt_compression`), true, `${name}, ${variant}: ${extensionsRequired}`);
  if (variant.startsWith('condensed')) assert.ok(extensionsRequired.includes('PSPLIT_mesh_draco_patches'), `${name}, ${variant}`);
}

const pool = psplit.createPool({ workers: 2 });
after(() => pool.dispose());

test('three in Node.js', { skip }, async () => {
  const draco = new PsplitDracoLoader().setWorkerLimit(1);
  after(() => draco.dispose());
  const load = async (name, variant) => of_three(await make_loader({ draco, plugin: { pool } }).parseAsync(buffer_of(readFileSync(file(name, variant))), ''));
  const originals = Object.fromEntries(await Promise.all(names.map(async (name) => [name, await load(name, 'original')])));
  assert.deepEqual(counts_of(originals.made), { primitives: 2, bones: 2, tracks: 4, targets: 3 });
  for (const [name, variant] of all()) {
    assert_extensions(name, variant);
    assert.deepEqual(character_differences(originals[name], await load(name, variant)), [], `${name}, ${variant}`);
  }
});

test('Babylon.js in Node.js', { skip }, async () => {
  const babylon = (name) => import(pathToFileURL(path.join(modules_folder, 'node_modules/@babylonjs', name)));
  const { NullEngine } = await babylon('core/Engines/nullEngine.js'), { Scene } = await babylon('core/scene.js');
  const { DracoDecoder } = await babylon('core/Meshes/Compression/dracoDecoder.js'), { LoadAssetContainerAsync } = await babylon('core/Loading/sceneLoader.js');
  const { MeshoptCompression } = await babylon('core/Meshes/Compression/meshoptCompression.js');
  const { registerGLTFExtension } = await babylon('loaders/glTF/2.0/index.js'), { registerPsplit } = await import(pathToFileURL(path.join(package_folder, 'babylon.js')));
  registerPsplit(registerGLTFExtension, { pool });
  // Babylon.js loads the decoders' scripts, which takes a page.
  const of_draco = (name) => path.join(package_folder, 'draco', name);
  DracoDecoder.DefaultConfiguration = { wasmUrl: 'not used', wasmBinaryUrl: 'not used', wasmBinary: readFileSync(of_draco('draco_decoder.wasm')),
    jsModule: (await import(pathToFileURL(of_draco('draco_wasm_wrapper.js')))).default, numWorkers: 0 };
  Object.defineProperty(MeshoptCompression, 'Default', { value: {
    decodeGltfBufferAsync: (source, ...rest) => MeshoptDecoder.decodeGltfBufferAsync(rest[0], rest[1], source, rest[2], rest[3]) } });
  const engine = new NullEngine();
  after(() => engine.dispose());
  const load = async (name, variant) => {
    const scene = new Scene(engine);
    try {
      return of_babylon(await LoadAssetContainerAsync(new Uint8Array(readFileSync(file(name, variant))), scene, kBabylonOptions));
    } finally {
      scene.dispose();
    }
  };
  const originals = {};
  for (const name of names) originals[name] = await load(name, 'original');
  assert.deepEqual(counts_of(originals.made), { primitives: 2, bones: 2, tracks: 6, targets: 3 });
  for (const [name, variant] of all(for_babylon))
    assert.deepEqual(character_differences(originals[name], await load(name, variant)), [], `${name}, ${variant}`);
});

// Rows of one view, as `count` points whose attributes of 4 bytes fill them.
function rows_of(stride, count, kind) {
  const rows = new DataView(new ArrayBuffer(stride * count));
  for (let i = 0; i < count; ++i)
    for (let c = 0; c < stride; c += 4) {
      const noise = Math.imul(i * 64 + c + 1, 2654435761) >>> 0, at = i * stride + c;
      if (kind === 'noise') rows.setUint32(at, Math.imul(noise, noise >>> 7) >>> 0, true);
      if (kind === 'floats') rows.setFloat32(at, i / 10 + c, true);
      if (kind === 'shorts') {
        rows.setInt16(at, 40 * c - 90 * i + noise % 3, true);
        rows.setUint16(at + 2, (i * i + c) % 501, true);
      }
      if (kind === 'runs') rows.setUint32(at, i % 200 < 70 ? noise : 7 + (i >> 5), true);
    }
  return new Uint8Array(rows.buffer);
}

// The bytes of every accessor of a GLB, whose views are plain or given decoded.
function accessor_bytes(file, decoded = {}) {
  const { json, view_bytes } = read_asset(file);
  return json.accessors.map(({ bufferView, byteOffset = 0, count }) => {
    const { byteStride = 4 } = json.bufferViews[bufferView], view = decoded[bufferView] ?? view_bytes(bufferView);
    return Buffer.concat(Array.from({ length: count }, (_, i) => view.subarray(byteOffset + i * byteStride, byteOffset + i * byteStride + 4)));
  });
}

test("the codec's version 1, by meshoptimizer and by psplit", { skip }, async () => {
  const { MeshoptEncoder, MeshoptDecoder: newest } = createRequire(path.join(modules_folder, 'package.json'))('meshoptimizer');
  const of_three = (await import(pathToFileURL(path.join(modules_folder, 'node_modules/three/examples/jsm/libs/meshopt_decoder.module.js')))).MeshoptDecoder;
  await Promise.all([MeshoptEncoder.ready, newest.ready, of_three.ready]);
  const name = 'KHR_meshopt_compression', cases = [];
  for (const stride of [4, 8, 12, 16, 24, 64, 100, 252])
    for (const count of [16, 250, 257, 700]) for (const kind of ['noise', 'floats', 'shorts', 'runs']) cases.push({ stride, count, rows: rows_of(stride, count, kind) });
  const colors = MeshoptEncoder.encodeFilterColor(Float32Array.from({ length: 4 * 300 }, (_, i) => Math.sin(i) ** 2), 300, 4, 8);
  cases.push({ stride: 4, count: 300, rows: colors, filter: 'COLOR' });
  const json = { asset: { version: '2.0' }, extensionsUsed: [name], extensionsRequired: [name], buffers: [{}, { byteLength: 0, extensions: { [name]: { fallback: true } } }],
    bufferViews: [], accessors: [], meshes: [] };
  const expected = [];
  let bytes = Buffer.alloc(0);
  for (const [index, { stride, count, rows, filter }] of cases.entries()) {
    const packed = MeshoptEncoder.encodeVertexBufferLevel(rows, count, stride, index % 4, 1), values = new Uint8Array(rows.length);
    newest.decodeVertexBuffer(values, count, stride, packed, filter);
    assert.equal(packed[0], 0xa1);
    const attributes = {};
    for (let offset = 0; offset < stride; offset += 4) {
      attributes[`_A${offset / 4}`] = json.accessors.push({ bufferView: index, byteOffset: offset, componentType: 5121, normalized: true, type: 'VEC4', count }) - 1;
      expected.push(Buffer.concat(Array.from({ length: count }, (_, i) => values.subarray(i * stride + offset, i * stride + offset + 4))));
    }
    json.meshes.push({ primitives: [{ mode: 0, attributes }] });
    json.bufferViews.push({ buffer: 1, byteOffset: json.buffers[1].byteLength, byteLength: rows.length, byteStride: stride, extensions: { [name]:
      { buffer: 0, byteOffset: bytes.length, byteLength: packed.length, byteStride: stride, count, mode: 'ATTRIBUTES', ...(filter && { filter }) } } });
    json.buffers[1].byteLength += rows.length;
    bytes = Buffer.concat([bytes, packed, Buffer.alloc(-packed.length & 3)]);
  }
  json.buffers[0].byteLength = bytes.length;
  const files = ['theirs', 'plain', 'ours'].map((of) => path.join(folder, `version1.${of}.glb`)), [theirs, plain, ours] = files;
  writeFileSync(theirs, make_glb(json, bytes));
  execFileSync(gltf_psplit, ['decode', '-q', '-f', theirs, plain]);
  // Filters are exact to one step.
  const colored = expected.length - 1, decoded = accessor_bytes(plain);
  assert.deepEqual(decoded.slice(0, colored), expected.slice(0, colored));
  assert.ok(decoded[colored].every((value, i) => Math.abs(value - expected[colored][i]) <= 1));

  execFileSync(gltf_psplit, ['encode', '-q', '-f', plain, ours, '--lossless', '--meshopt=khr']);
  // Accessors that are equal became one.
  const distinct = (list) => [...new Set(list.map((values) => values.toString('hex')))].sort();
  const { json: { bufferViews } } = read_asset(ours), glb = readFileSync(ours), binary = glb.subarray(28 + glb.readUInt32LE(12));
  for (const decoder of [newest, of_three]) {
    const views = {};
    for (const [index, { extensions }] of bufferViews.entries()) {
      const { byteOffset = 0, byteLength, byteStride, count, mode, filter } = extensions?.[name] ?? {};
      if (mode === undefined) continue;
      const packed = binary.subarray(byteOffset, byteOffset + byteLength);
      assert.equal(packed[0], 0xa1);
      views[index] = new Uint8Array(count * byteStride);
      decoder.decodeGltfBuffer(views[index], count, byteStride, packed, mode, filter);
    }
    assert.ok(Object.keys(views).length > 0);
    assert.deepEqual(distinct(accessor_bytes(ours, views)), distinct(decoded));
  }
});

const imports = { three: '/modules/three/build/three.module.js', 'three/addons/': '/modules/three/examples/jsm/',
  '@babylonjs/core/': '/modules/@babylonjs/core/', '@babylonjs/loaders/': '/modules/@babylonjs/loaders/' };
const page = `<!doctype html><script type="importmap">${JSON.stringify({ imports })}</script><script type="module" src="/main.js"></script>`;
const tests_folder = path.join(root, 'tests/web'), site = { skip, types: { '.cjs': 'text/javascript' }, files: { '/': page, '/assets/': { folder },
  '/compare_characters.mjs': { folder: path.join(tests_folder, 'compare_characters.mjs') }, '/compare_scenes.mjs': { folder: path.join(tests_folder, 'compare_scenes.mjs') } } };

// Sets differences(name, variant) in the page: how much of the original there is, and in what the asset differs, loaded as a whole
// and while it arrives.
async function prepare_three() {
  const { MeshStandardMaterial } = await import('three'), { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
  const { MeshoptDecoder } = await import('three/addons/libs/meshopt_decoder.module.js');
  const { createPool } = await import('/psplit/index.js'), { loadStreaming, PsplitDracoLoader, PsplitPlugin } = await import('/psplit/three.js');
  const { plain_materials } = await import('/compare_scenes.mjs'), { character_differences, counts_of, of_three } = await import('/compare_characters.mjs');
  const pool = createPool({ workers: 2 }), draco = new PsplitDracoLoader().setWorkerLimit(1);
  const make = () => new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).setDRACOLoader(draco).register(plain_materials(MeshStandardMaterial));
  const load = (url) => make().register((parser) => new PsplitPlugin(parser, { pool })).loadAsync(url);
  const stream = async (url) => {
    const made = await loadStreaming(make(), url, { pool });
    await made.psplit.whole;
    return made;
  };
  globalThis.differences = async (name, variant) => {
    const original = of_three(await load(`/assets/${name}.original.glb`)), url = `/assets/${name}.${variant}.glb`;
    return [counts_of(original), ...await Promise.all([load, stream].map(async (way) => character_differences(original, of_three(await way(url)))))];
  };
}
async function prepare_babylon(options) {
  const { NullEngine } = await import('@babylonjs/core/Engines/nullEngine.js'), { Scene } = await import('@babylonjs/core/scene.js');
  const { LoadAssetContainerAsync } = await import('@babylonjs/core/Loading/sceneLoader.js');
  const { MeshoptCompression } = await import('@babylonjs/core/Meshes/Compression/meshoptCompression.js');
  const { registerGLTFExtension } = await import('@babylonjs/loaders/glTF/2.0/index.js');
  const { createPool } = await import('/psplit/index.js'), { loadStreaming, registerPsplit } = await import('/psplit/babylon.js');
  const { character_differences, counts_of, of_babylon } = await import('/compare_characters.mjs');
  const { DracoDecoder } = await import('@babylonjs/core/Meshes/Compression/dracoDecoder.js');
  DracoDecoder.DefaultConfiguration = { wasmUrl: '/psplit/draco/draco_wasm_wrapper.js', wasmBinaryUrl: '/psplit/draco/draco_decoder.wasm' };
  MeshoptCompression.Configuration = { decoder: { url: '/modules/meshoptimizer/meshopt_decoder.cjs' } };
  registerPsplit(registerGLTFExtension, { pool: createPool({ workers: 2 }) });
  const engine = new NullEngine();
  const load = (url, scene) => LoadAssetContainerAsync(url, scene, options);
  const stream = async (url, scene) => {
    const made = await loadStreaming(LoadAssetContainerAsync, url, scene, options);
    await made.psplit.whole;
    return made;
  };
  const made_by = async (way, url) => {
    const scene = new Scene(engine), made = of_babylon(await way(url, scene));
    scene.dispose();
    return made;
  };
  globalThis.differences = async (name, variant) => {
    const original = await made_by(load, `/assets/${name}.original.glb`), url = `/assets/${name}.${variant}.glb`;
    // Babylon.js' loadStreaming refuses assets without patches.
    const ways = variant.startsWith('condensed') ? [load, stream] : [load];
    return [counts_of(original), ...await Promise.all(ways.map(async (way) => character_differences(original, await made_by(way, url))))];
  };
}

for (const [loader, script, chosen, options, tracks] of [['three', prepare_three, () => true, undefined, 4], ['Babylon.js', prepare_babylon, for_babylon, kBabylonOptions, 6]])
  page_test(`${loader} in Chromium`, { ...site, script, argument: options }, async ({ result, page }) => {
    await result;
    for (const [name, variant] of all(chosen)) {
      const [counts, ...differences] = await page.evaluate((...of) => globalThis.differences(...of), name, variant);
      assert.deepEqual(differences.flat(), [], `${name}, ${variant}`);
      if (name === 'made') assert.deepEqual(counts, { primitives: 2, bones: 2, tracks, targets: 3 });
    }
  });
