// registerPsplit with the option `gpu`: Babylon.js' WebGPU engine draws from the buffers that shaders decoded, on Dawn in Node.js.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { start_site } from './browser.mjs';
import { gltf_psplit, modules_folder, package_folder, psplit, with_asset } from './load.mjs';
import { are_equal } from './webgpu_compare.js';
import { skip as no_device } from './webgpu_device.mjs';

const skip = no_device || (gltf_psplit === null && 'there is no gltf-psplit');
const kSize = 128;
const pool = psplit.createPool({ workers: 1 });
after(() => pool.dispose());

const of_modules = (name) => import(pathToFileURL(path.join(modules_folder, 'node_modules/@babylonjs', name)));
const { loadStreaming, patchesOf, registerPsplit } = await import(pathToFileURL(path.join(package_folder, 'babylon.js')));
const { registerGLTFExtension } = await of_modules('loaders/glTF/2.0/index.js');
const { LoadAssetContainerAsync } = await of_modules('core/Loading/sceneLoader.js'), { Scene } = await of_modules('core/scene.js');
const { FreeCamera } = await of_modules('core/Cameras/freeCamera.js'), { Vector3 } = await of_modules('core/Maths/math.vector.js');
const { HemisphericLight } = await of_modules('core/Lights/hemisphericLight.js'), { StandardMaterial } = await of_modules('core/Materials/standardMaterial.js');
const { Logger } = await of_modules('core/Misc/logger.js');
Logger.LogLevels = Logger.ErrorLogLevel;

// What the engine asks of a page: WebGPU, and a canvas, which is a texture.
async function make_engine() {
  const { gpu_of_tests: gpu, adapter_of_tests: adapter } = globalThis;
  Object.getPrototypeOf(adapter.features).forEach ??= function (use) {
    for (const feature of this) use(feature);
  };
  gpu.getPreferredCanvasFormat ??= () => 'rgba8unorm';
  Object.defineProperty(globalThis, 'navigator', { value: { gpu, userAgent: '' }, configurable: true });
  let texture;
  const context = { getCurrentTexture: () => texture, unconfigure() {}, configure({ device, format, usage }) {
    texture = device.createTexture({ size: [kSize, kSize], format, usage: usage | GPUTextureUsage.COPY_SRC });
  } };
  const canvas = { width: kSize, height: kSize, clientWidth: kSize, clientHeight: kSize, style: {}, addEventListener() {}, removeEventListener() {},
    setAttribute() {}, getBoundingClientRect: () => ({ width: kSize, height: kSize }), getContext: () => context };
  const { WebGPUEngine } = await of_modules('core/Engines/webgpuEngine.js'), engine = new WebGPUEngine(canvas, { antialias: false });
  await engine.initAsync();
  engine._device.addEventListener('uncapturederror', ({ error }) => {
    throw error;
  });
  return engine;
}
const engine = skip ? null : await make_engine();

const kOptions = { pluginExtension: '.glb', pluginOptions: { gltf: { skipMaterials: true } } };
// The scene of a GLB, and its meshes that have points.
async function load(glb, options, use = (scene) => LoadAssetContainerAsync(new Uint8Array(glb), scene, kOptions)) {
  registerPsplit(registerGLTFExtension, { pool, ...options });
  const scene = new Scene(engine), container = await use(scene);
  container.addAllToScene();
  return { scene, psplit: container.psplit, meshes: scene.meshes.filter((mesh) => mesh.getTotalVertices() > 0) };
}
async function picture({ scene, meshes: [mesh] }) {
  const { boundingSphere: { centerWorld, radiusWorld } } = mesh.getBoundingInfo(), camera = new FreeCamera('camera', centerWorld.add(new Vector3(0, radiusWorld, -2.5 * radiusWorld)), scene);
  camera.setTarget(centerWorld);
  Object.assign(camera, { minZ: 0.01, maxZ: 1000 });
  new HemisphericLight('light', new Vector3(0.3, 1, 0), scene);
  for (const each of scene.meshes) Object.assign(each, { material: Object.assign(new StandardMaterial('grey', scene), { backFaceCulling: false }) });
  await scene.whenReadyAsync();
  engine.beginFrame();
  scene.render();
  engine.endFrame();
  return engine.readPixels(0, 0, kSize, kSize);
}
async function read(buffer, bytes) {
  const device = engine._device, copy = device.createBuffer({ size: buffer.size, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ }), encoder = device.createCommandEncoder();
  encoder.copyBufferToBuffer(buffer, 0, copy, 0, buffer.size);
  device.queue.submit([encoder.finish()]);
  await copy.mapAsync(GPUMapMode.READ);
  return new Uint8Array(copy.getMappedRange()).slice(0, bytes);
}
const glb_of = (faces, ...options) => with_asset(faces, options, (file) => readFileSync(file));
const colours = (pixels) => new Set(new Uint32Array(pixels.buffer)).size;

test('the engine draws from buffers of the decoder', { skip }, async () => {
  const glb = glb_of(3000, '--patch-faces', '400'), by_gpu = await load(glb, { gpu: true }), by_wasm = await load(glb);
  const [mesh] = by_gpu.meshes, [other] = by_wasm.meshes, facts = patchesOf(mesh), { geometry } = mesh;
  assert.equal(facts.way, 'gpu');
  assert.deepEqual({ ...facts, way: 'wasm' }, patchesOf(other));
  assert.equal(facts.patchCount > 4, true);
  assert.deepEqual([mesh.getTotalVertices(), mesh.getTotalIndices()], [facts.pointCount, 3 * facts.faceCount]);
  // The buffers have what WebAssembly decoded.
  assert.ok(are_equal(await read(geometry.getIndexBuffer().underlyingResource, 12 * facts.faceCount), Uint32Array.from(other.getIndices())));
  for (const kind of other.getVerticesDataKinds()) {
    assert.equal(mesh.getVerticesData(kind), null);
    const expected = other.getVerticesData(kind);
    assert.ok(are_equal(await read(mesh.getVertexBuffer(kind).getBuffer().underlyingResource, expected.byteLength), expected), kind);
  }
  const { minimum, maximum } = mesh.getBoundingInfo(), of_other = other.getBoundingInfo();
  assert.deepEqual([minimum, maximum].map((corner) => corner.asArray()), [of_other.minimum, of_other.maximum].map((corner) => corner.asArray()));
  const pixels = await picture(by_gpu);
  assert.ok(colours(pixels) > 20);
  assert.deepEqual(pixels, await picture(by_wasm));
  // They end with the mesh.
  const ended = [], buffers = [geometry.getIndexBuffer(), ...mesh.getVerticesDataKinds().map((kind) => mesh.getVertexBuffer(kind).getBuffer())];
  for (const { underlyingResource } of buffers) underlyingResource.destroy = () => ended.push(underlyingResource);
  mesh.dispose();
  engine.beginFrame();
  engine.endFrame();
  assert.equal(new Set(ended).size, buffers.length);
});

// A GLB with changed JSON.
function changed(glb, change) {
  const length = glb.readUInt32LE(12), json = JSON.parse(glb.subarray(20, 20 + length).toString()), rest = glb.subarray(20 + length);
  change(json);
  const text = JSON.stringify(json), bytes = Buffer.from(text.padEnd(Math.ceil(text.length / 4) * 4)), head = Buffer.from(glb.subarray(0, 20));
  head.writeUInt32LE(bytes.length, 12);
  head.writeUInt32LE(20 + bytes.length + rest.length, 8);
  return Buffer.concat([head, bytes, rest]);
}

test('two meshes of one container share its buffers', { skip }, async () => {
  const glb = changed(glb_of(1500, '--patch-faces', '300'), (json) => {
    json.meshes.push(structuredClone(json.meshes[0]));
    json.nodes.push({ mesh: 1, translation: [0, 1, 0] });
    json.scenes[0].nodes.push(json.nodes.length - 1);
  });
  const { scene, meshes } = await load(glb, { gpu: true });
  assert.deepEqual(meshes.map((mesh) => patchesOf(mesh).way), ['gpu', 'gpu']);
  const [first, second] = meshes.map(({ geometry }) => geometry), { underlyingResource } = first.getIndexBuffer();
  assert.equal(second.getIndexBuffer(), first.getIndexBuffer());
  let ended = false;
  underlyingResource.destroy = () => (ended = true);
  meshes[0].dispose();
  engine.beginFrame();
  engine.endFrame();
  assert.equal(ended, false);
  assert.ok(colours(await picture({ scene, meshes: meshes.slice(1) })) > 20);
  meshes[1].dispose();
  engine.beginFrame();
  engine.endFrame();
  assert.equal(ended, true);
});

test('what the shaders do not decode, and what Babylon.js reads itself', { skip }, async () => {
  const plain = glb_of(1500, '--patch-faces', '300');
  for (const [glb, why] of [[glb_of(1500, '--patch-faces', '300', '--quantize-position', '24', '--encode-speed', '3'), /shaders/],
    [changed(plain, ({ accessors }) => accessors.forEach((accessor) => delete accessor.min)), /without bounds/]]) {
    const loaded = await load(glb, { gpu: true }), [mesh] = loaded.meshes, facts = patchesOf(mesh);
    assert.equal(facts.way, 'wasm');
    assert.match(facts.why, why);
    assert.ok(mesh.getIndices().length > 0 && colours(await picture(loaded)) > 20);
  }
  assert.equal(patchesOf({}), null);
  // An engine without WebGPU.
  const { NullEngine } = await of_modules('core/Engines/nullEngine.js');
  registerPsplit(registerGLTFExtension, { pool, gpu: true });
  const { meshes } = await LoadAssetContainerAsync(new Uint8Array(plain), new Scene(new NullEngine()), kOptions), mesh = meshes.find((each) => each.getTotalVertices() > 0);
  assert.equal(patchesOf(mesh).way, 'wasm');
  assert.match(patchesOf(mesh).why, /no WebGPU device/);
  // A broken container has the error of WebAssembly.
  const broken = Buffer.from(plain);
  broken.fill(0, broken.length - 400);
  await assert.rejects(load(broken, { gpu: true }), /PSPLIT_mesh_draco_patches: .*(patch|container)/);
});

test('attributes that Babylon.js does not read leave no buffers', { skip }, async () => {
  const glb = changed(glb_of(600, '--patch-faces', '300'), ({ meshes: [{ primitives: [{ attributes, extensions: { PSPLIT_mesh_draco_patches: patches } }] }] }) => {
    for (const of of [attributes, patches.attributes]) {
      of._MINE = of.TEXCOORD_0;
      delete of.TEXCOORD_0;
    }
  });
  const { createBuffer } = engine._device, made = new Set();
  engine._device.createBuffer = (descriptor) => {
    const buffer = createBuffer.call(engine._device, descriptor), { destroy } = buffer;
    if (descriptor.usage & GPUBufferUsage.VERTEX) made.add(buffer);
    buffer.destroy = () => (made.delete(buffer), destroy.call(buffer));
    return buffer;
  };
  try {
    const { meshes: [mesh] } = await load(glb, { gpu: true });
    assert.equal(patchesOf(mesh).way, 'gpu');
    assert.deepEqual([...made], ['position', 'normal'].map((kind) => mesh.getVertexBuffer(kind).getBuffer().underlyingResource));
  } finally {
    delete engine._device.createBuffer;
  }
});

test('loadStreaming', { skip }, async () => {
  const site = await start_site({ files: { '/a.glb': glb_of(1500, '--patch-faces', '300') } }), progress = [];
  try {
    const stream = (options) => (scene) => loadStreaming(LoadAssetContainerAsync, `${site.origin}/a.glb`, scene, { pluginOptions: kOptions.pluginOptions, ...options });
    const { meshes: [mesh], psplit: { whole } } = await load(null, { gpu: true }, stream({ onProgress: (...counts) => progress.push(counts) }));
    await whole;
    const { way, patchCount } = patchesOf(mesh);
    assert.equal(way, 'gpu');
    assert.deepEqual(progress, [[patchCount, patchCount]]);
    const chosen = await load(null, { gpu: true }, stream({ choose: () => [0, 2] }));
    await chosen.psplit.whole;
    const facts = patchesOf(chosen.meshes[0]);
    assert.deepEqual([facts.way, facts.why, [...facts.chosen]], ['wasm', 'chosen patches', [0, 2]]);
    const stop = new AbortController();
    stop.abort();
    await assert.rejects(load(null, { gpu: true }, stream({ signal: stop.signal })), { code: 'aborted' });
  } finally {
    site.close();
  }
});
