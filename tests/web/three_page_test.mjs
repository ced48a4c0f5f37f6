// What psplit/three loads is drawn by three in Chromium: whole and patch by patch, with and without shared memory.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import path from 'node:path';
import { page_test } from './browser.mjs';
import { gltf_psplit, root } from './load.mjs';

const skip = gltf_psplit === null && 'there is no gltf-psplit';
const folder = path.join(root, 'build/web/drawn'), file = (name) => path.join(folder, name);
if (skip === false) {
  mkdirSync(folder, { recursive: true });
  const run = (...options) => execFileSync(gltf_psplit, [...options, '-q']);
  // Large enough for two workers.
  run('generate', file('mesh.glb'), '--shape', 'blob', '--faces', '80k', '--normals');
  run('encode', file('mesh.glb'), file('patches.glb'), '--patch-faces', '4000');
  run('decode', file('patches.glb'), file('plain.glb'));
}

const kImports = { three: '/modules/three/build/three.module.js', 'three/addons/': '/modules/three/examples/jsm/' };
const page = `<!doctype html><script type="importmap">${JSON.stringify({ imports: kImports })}</script>
  <script type="module" src="/main.js"></script>`;

// The digests of pictures of the model, loaded in three ways, and what its arrays and its parts were.
async function draw() {
  const { AmbientLight, DirectionalLight, PerspectiveCamera, Scene, WebGLRenderer } = await import('three');
  const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
  const { createPool } = await import('/psplit/index.js'), { PsplitPlugin } = await import('/psplit/three.js');
  const { digest } = await import('/page.js');
  const renderer = new WebGLRenderer(), pool = createPool({ workers: 2 });
  renderer.setSize(256, 256);
  const picture_of = (model) => {
    const scene = new Scene().add(model, new AmbientLight('#fff', 1), new DirectionalLight('#fff', 2));
    const camera = new PerspectiveCamera(50, 1, 0.1, 10);
    camera.position.set(1.5, 1, 2.5);
    camera.lookAt(0, 0, 0);
    renderer.render(scene, camera);
    const pixels = new Uint8Array(4 * 256 * 256), gl = renderer.getContext();
    gl.readPixels(0, 0, 256, 256, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  };
  const drawn_pixels = (pixels) => pixels.reduce((count, value, i) => count + (i % 4 === 0 && value > 0 ? 1 : 0), 0);
  const positions_of = (gltf) => {
    let found;
    gltf.scene.traverse((object) => (found = object.isMesh ? object.geometry.attributes.position : found));
    return found;
  };
  const load = (url, options) => {
    const loader = new GLTFLoader();
    loader.register((parser) => new PsplitPlugin(parser, { pool, ...options }));
    return loader.loadAsync(url);
  };
  const plain = picture_of((await load('/drawn/plain.glb')).scene), whole = await load('/drawn/patches.glb');
  let growing = null, steps = [];
  const draw_growing = () => growing !== null && steps.push(drawn_pixels(picture_of(growing.scene)));
  growing = await load('/drawn/patches.glb', { patchByPatch: true, onProgress: draw_growing });
  draw_growing();
  await growing.psplit.whole;
  const result = { isolated: globalThis.crossOriginIsolated, drawn: drawn_pixels(plain), plain: await digest(plain),
    whole: await digest(picture_of(whole.scene)), growing: await digest(picture_of(growing.scene)), steps,
    buffer: positions_of(whole).array.buffer.constructor.name };
  pool.dispose();
  return result;
}

for (const is_isolated of [false, true])
  page_test(`drawn ${is_isolated ? 'from shared memory' : 'without shared memory'}`, {
    skip, script: draw, files: { '/': page, '/drawn/': { folder } },
    headers: is_isolated ? { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' } : {},
  }, async ({ result }) => {
    const { isolated, drawn, plain, whole, growing, steps, buffer } = await result;
    assert.equal(isolated, is_isolated);
    assert.ok(drawn > 5000, `${drawn} pixels`);
    assert.equal(whole, plain);
    assert.equal(growing, plain);
    assert.ok(steps.length > 0 && steps[0] <= drawn, `${steps}`);
    assert.equal(buffer, is_isolated ? 'SharedArrayBuffer' : 'ArrayBuffer');
  });
