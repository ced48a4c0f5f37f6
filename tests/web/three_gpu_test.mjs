// PsplitPlugin with the option `gpu`: three's WebGPURenderer draws from the buffers that shaders decoded. On Dawn in Node.js, to a render
// target, because there is no canvas.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { gltf_psplit, modules_folder, psplit, with_asset } from './load.mjs';
import { buffer_of, make_loader, THREE } from './three_loaders.mjs';
import { request_device, skip as no_device } from './webgpu_device.mjs';

const skip = no_device || (gltf_psplit === null && 'there is no gltf-psplit');
const kSize = 128;
const pool = psplit.createPool({ workers: 1 });
after(() => pool.dispose());

// What three asks of a page.
globalThis.requestAnimationFrame ??= () => 0;
globalThis.cancelAnimationFrame ??= () => {};
const canvas = () => ({ width: kSize, height: kSize, style: {}, addEventListener() {}, removeEventListener() {}, getContext: () => null });

async function make_renderer() {
  const { WebGPURenderer } = await import(pathToFileURL(path.join(modules_folder, 'node_modules/three/build/three.webgpu.js')));
  const errors = [], renderer = new WebGPURenderer({ canvas: canvas(), device: await request_device() });
  await renderer.init();
  renderer.onError = ({ message }) => errors.push(message);
  return { renderer, errors };
}

const meshes_of = (scene) => {
  const meshes = [];
  scene.traverse((object) => object.isMesh && meshes.push(object));
  return meshes;
};

// The pixels of a scene, whose colours are its normals.
async function picture({ renderer, errors }, scene) {
  const target = new THREE.RenderTarget(kSize, kSize), camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
  const sphere = new THREE.Box3().setFromObject(scene).getBoundingSphere(new THREE.Sphere());
  camera.position.copy(sphere.center).add(new THREE.Vector3(0, sphere.radius, 2.5 * sphere.radius));
  camera.lookAt(sphere.center);
  for (const mesh of meshes_of(scene)) mesh.material = new THREE.MeshNormalMaterial();
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const pixels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, kSize, kSize);
  renderer.setRenderTarget(null);
  assert.deepEqual(errors, []);
  return pixels;
}
const load = (glb, plugin) => make_loader({ plugin: { pool, ...plugin } }).parseAsync(buffer_of(glb), '');
const glb_of = (faces, ...options) => with_asset(faces, options, (file) => readFileSync(file));

test('the renderer draws from buffers of the decoder', { skip }, async () => {
  const glb = glb_of(3000, '--patch-faces', '400'), of = await make_renderer(), { renderer } = of, progress = [];
  const { scene, psplit: plugin } = await load(glb, { gpu: renderer, onProgress: (done, total) => progress.push([done, total]) });
  const plain = await load(glb), [mesh] = meshes_of(scene), [other] = meshes_of(plain.scene), { geometry } = mesh;
  const facts = plugin.patchesOf(mesh);
  assert.equal(facts.way, 'gpu');
  assert.deepEqual({ ...facts, way: 'wasm' }, plain.psplit.patchesOf(other));
  assert.deepEqual(progress, [[facts.patchCount, facts.patchCount]]);
  assert.ok(Object.values(geometry.attributes).every(({ array, count }) => array.length === 0 && count === facts.pointCount));
  const by_gpu = await picture(of, scene), by_wasm = await picture(of, plain.scene);
  assert.ok(new Set(by_gpu).size > 20);
  assert.deepEqual(by_gpu, by_wasm);
  // The renderer reads them back.
  for (const [name, { array }] of [...Object.entries(other.geometry.attributes)]) {
    const bytes = await renderer.getArrayBufferAsync(geometry.attributes[name]);
    assert.deepEqual(new array.constructor(bytes, 0, array.length), array, name);
  }
  // Its buffers end with the geometry.
  const { backend } = renderer, { buffer } = backend.get(geometry.index);
  let ended = false;
  buffer.destroy = () => (ended = true);
  geometry.dispose();
  assert.ok(ended && !backend.has(geometry.index));
});

test('several meshes, and what the shaders do not decode', { skip }, async () => {
  const of = await make_renderer(), { renderer } = of;
  const way = async (glb, plugin) => {
    const { scene, psplit: { patchesOf }, psplit: of_scene } = await load(glb, plugin), [mesh] = meshes_of(scene);
    assert.equal(typeof patchesOf, 'function');
    return { ...of_scene.patchesOf(mesh), length: mesh.geometry.attributes.position.array.length, scene };
  };
  const fine = await way(glb_of(1500, '--patch-faces', '300', '--quantize-position', '24', '--encode-speed', '3'), { gpu: renderer });
  assert.equal(fine.way, 'wasm');
  assert.match(fine.why, /shaders/);
  assert.ok(fine.length > 0 && new Set(await picture(of, fine.scene)).size > 20);
  const condensed = await way(glb_of(1500, '--patch-faces', '300', '--condense'), { gpu: renderer });
  assert.deepEqual([condensed.way, condensed.length], ['gpu', 0]);
  assert.ok(new Set(await picture(of, condensed.scene)).size > 20);
  const plain = glb_of(1500, '--patch-faces', '300');
  for (const gpu of [{ backend: { isWebGLBackend: true } }, {}, { backend: null, init: async () => { throw new Error('no adapter'); } }]) {
    const { way: by, why, length } = await way(plain, { gpu });
    assert.equal(by, 'wasm');
    assert.match(why, /no WebGPU device|no adapter/);
    assert.ok(length > 0);
  }
  // Loads at the same time are one batch, and one that is broken is not the others' failure.
  const broken = Uint8Array.from(plain);
  broken.fill(0, -400);
  const loads = await Promise.allSettled([plain, broken, plain].map((glb) => way(glb, { gpu: renderer })));
  assert.deepEqual(loads.map(({ status, value }) => value?.way ?? status), ['gpu', 'rejected', 'gpu']);
  assert.equal(loads[1].reason.code, 'invalid-input');
  const stop = new AbortController(), aborted = way(plain, { gpu: renderer, signal: stop.signal });
  stop.abort();
  await assert.rejects(aborted, { code: 'aborted' });
});
