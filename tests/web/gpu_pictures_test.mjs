// Pictures in Chromium of what shaders decoded, and of what WebAssembly decoded: by three's WebGPURenderer and by Babylon.js' WebGPUEngine,
// on canvases of WebGPU. The processor computes them.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { page_test } from './browser.mjs';
import { gltf_psplit, with_asset } from './load.mjs';

const skip = gltf_psplit === null && 'there is no gltf-psplit';
// On a busy machine, a processor compiles the shaders in half a minute.
const kMostMs = 180000, kSize = 256, glb = skip ? null : with_asset(3000, ['--patch-faces', '400'], (file) => readFileSync(file));
const page_of = (imports) => `<!doctype html><style>body { margin: 0 }</style><canvas width="${kSize}" height="${kSize}"></canvas>
  <script type="importmap">${JSON.stringify({ imports })}</script><script type="module" src="/main.js"></script>`;

// Both leave show(name) to the page, which draws a model, and return the ways.
async function by_three(size) {
  const { AmbientLight, Box3, DirectionalLight, PerspectiveCamera, Scene, Sphere, Vector3 } = await import('three');
  const { WebGPURenderer } = await import('three/webgpu'), { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
  const { createPool } = await import('/psplit/index.js'), { PsplitPlugin } = await import('/psplit/three.js');
  const renderer = new WebGPURenderer({ canvas: document.querySelector('canvas') }), pool = createPool({ workers: 1 });
  renderer.setSize(size, size);
  await renderer.init();
  if (renderer.backend.isWebGPUBackend !== true) throw new Error('three has no WebGPU');
  const ways = {}, models = {};
  for (const [name, options] of Object.entries({ gpu: { gpu: renderer }, wasm: {} })) {
    const loader = new GLTFLoader();
    loader.register((parser) => new PsplitPlugin(parser, { pool, ...options }));
    const { scene, psplit } = await loader.loadAsync('/model.glb');
    models[name] = scene;
    scene.traverse((object) => object.isMesh && (ways[name] = psplit.patchesOf(object).way));
  }
  globalThis.show = (name) => {
    const scene = new Scene(), camera = new PerspectiveCamera(40, 1, 0.01, 1000), light = new DirectionalLight('#fff', 3);
    light.position.set(1, 2, 0.5);
    scene.add(models[name], light, new AmbientLight('#fff', 0.4));
    const { center, radius } = new Box3().setFromObject(models[name]).getBoundingSphere(new Sphere());
    camera.position.copy(center).add(new Vector3(0, radius, 2.5 * radius));
    camera.lookAt(center);
    renderer.render(scene, camera);
  };
  return ways;
}
async function by_babylon() {
  const { WebGPUEngine } = await import('@babylonjs/core/Engines/webgpuEngine.js'), { registerGLTFExtension } = await import('@babylonjs/loaders/glTF/2.0/index.js');
  const { LoadAssetContainerAsync } = await import('@babylonjs/core/Loading/sceneLoader.js'), { Scene } = await import('@babylonjs/core/scene.js');
  const { FreeCamera } = await import('@babylonjs/core/Cameras/freeCamera.js'), { Vector3 } = await import('@babylonjs/core/Maths/math.vector.js');
  const { HemisphericLight } = await import('@babylonjs/core/Lights/hemisphericLight.js'), { StandardMaterial } = await import('@babylonjs/core/Materials/standardMaterial.js');
  const { createPool } = await import('/psplit/index.js'), { patchesOf, registerPsplit } = await import('/psplit/babylon.js');
  const engine = new WebGPUEngine(document.querySelector('canvas'), { antialias: false }), pool = createPool({ workers: 1 }), ways = {}, scenes = {};
  await engine.initAsync();
  for (const [name, gpu] of Object.entries({ gpu: true, wasm: false })) {
    registerPsplit(registerGLTFExtension, { pool, gpu });
    const scene = (scenes[name] = new Scene(engine)), container = await LoadAssetContainerAsync('/model.glb', scene, { pluginOptions: { gltf: { skipMaterials: true } } });
    container.addAllToScene();
    const mesh = scene.meshes.find((each) => each.getTotalVertices() > 0), { centerWorld, radiusWorld } = mesh.getBoundingInfo().boundingSphere;
    ways[name] = patchesOf(mesh).way;
    const camera = new FreeCamera('camera', centerWorld.add(new Vector3(0, radiusWorld, -2.5 * radiusWorld)), scene);
    camera.setTarget(centerWorld);
    Object.assign(camera, { minZ: 0.01, maxZ: 1000 });
    new HemisphericLight('light', new Vector3(0.3, 1, 0), scene);
    mesh.material = Object.assign(new StandardMaterial('grey', scene), { backFaceCulling: false });
    await scene.whenReadyAsync();
  }
  globalThis.show = (name) => {
    engine.beginFrame();
    scenes[name].render();
    engine.endFrame();
  };
  return ways;
}

// Draws a model, and takes a picture of the canvas as the page shows it: a PNG.
async function picture(page, name) {
  await page.evaluate((of) => new Promise((resolve) => requestAnimationFrame(() => {
    globalThis.show(of);
    requestAnimationFrame(() => requestAnimationFrame(resolve));
  })), name);
  return page.screenshot({ clip: { x: 0, y: 0, width: kSize, height: kSize }, encoding: 'base64' });
}
const colours_of = (page, png) => page.evaluate(async (data, size) => {
  const context = new OffscreenCanvas(size, size).getContext('2d');
  context.drawImage(await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob()), 0, 0);
  return new Set(new Uint32Array(context.getImageData(0, 0, size, size).data.buffer)).size;
}, png, kSize);

const kPages = { "three's WebGPURenderer": [by_three, { three: '/modules/three/build/three.module.js', 'three/webgpu': '/modules/three/build/three.webgpu.js', 'three/addons/': '/modules/three/examples/jsm/' }],
  "Babylon.js' WebGPUEngine": [by_babylon, { '@babylonjs/core/': '/modules/@babylonjs/core/', '@babylonjs/loaders/': '/modules/@babylonjs/loaders/' }] };
for (const [name, [script, imports]] of Object.entries(kPages))
  page_test(`${name} shows the same picture as of arrays of WebAssembly`, { skip, script, argument: kSize, timeout: kMostMs, files: { '/': page_of(imports), '/model.glb': glb } },
    async ({ result, page }) => {
      assert.deepEqual(await result, { gpu: 'gpu', wasm: 'wasm' });
      const by_gpu = await picture(page, 'gpu'), by_wasm = await picture(page, 'wasm');
      assert.ok(await colours_of(page, by_gpu) > 20);
      assert.equal(by_gpu, by_wasm);
    });
