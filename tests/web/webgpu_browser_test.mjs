// psplit/webgpu in Chromium, on a processor: the same results as WebAssembly's, and a page that draws them.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { page_test } from './browser.mjs';
import { gltf_psplit, make_container, root, with_asset } from './load.mjs';

const skip = gltf_psplit === null && 'there is no gltf-psplit';
const compare_file = { folder: fileURLToPath(new URL('webgpu_compare.js', import.meta.url)) };
const samples = skip ? [] : [make_container(1500, 300), make_container(400, 200, '--condense')];

page_test('containers in a page', { skip, argument: samples.map(({ attributes }) => attributes),
  files: { '/compare.js': compare_file, ...Object.fromEntries(samples.map(({ bytes }, i) => [`/${i}.bin`, bytes])) },
  script: async (requests) => {
    const { createGpuDecoder } = await import('/psplit/webgpu.js'), { decodeContainer } = await import('/psplit/index.js'), { compare } = await import('/compare.js');
    const device = await (await navigator.gpu.requestAdapter()).requestDevice();
    const containers = await Promise.all(requests.map(async (attributes, i) =>
      ({ name: `sample ${i}`, attributes, bytes: new Uint8Array(await (await fetch(`/${i}.bin`)).arrayBuffer()) })));
    return compare(await createGpuDecoder(device), decodeContainer, containers);
  } },
async ({ result }) => {
  const { equal, by_wasm, differences } = await result;
  assert.deepEqual({ equal, by_wasm, differences }, { equal: 2, by_wasm: 0, differences: [] });
});

// The example, without a library. A decoder with little memory leaves all to WebAssembly. Pictures are drawn to textures.
const kSize = 256, glb = skip ? null : with_asset(3000, ['--patch-faces', '400'], (file) => readFileSync(file));
page_test('the example draws the same picture as of arrays of WebAssembly', { skip, argument: kSize,
  files: { '/webgpu/': { folder: path.join(root, 'bindings/web/examples/webgpu') }, '/model.glb': glb,
    '/': `<!doctype html><meta charset="utf-8"><script type="importmap">{ "imports": { "psplit/webgpu": "/psplit/webgpu.js" } }</script>
      <script type="module" src="/main.js"></script>` },
  script: async (size) => {
    const { draw } = await import('/webgpu/main.js'), model = await (await fetch('/model.glb')).arrayBuffer();
    const device = await (await navigator.gpu.requestAdapter()).requestDevice(), format = 'rgba8unorm';
    const picture = async (options) => {
      const texture = device.createTexture({ size: [size, size], format, usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC });
      const { way } = await draw(device, model, { format, texture_of: () => texture }, options);
      const buffer = device.createBuffer({ size: 4 * size * size, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ }), encoder = device.createCommandEncoder();
      encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow: 4 * size }, [size, size]);
      device.queue.submit([encoder.finish()]);
      await buffer.mapAsync(GPUMapMode.READ);
      return { way, pixels: new Uint8Array(buffer.getMappedRange()).slice() };
    };
    const by_gpu = await picture(), by_wasm = await picture({ memory: 64 });
    const grey = by_gpu.pixels.filter((value, i) => i % 4 === 0 && value > 40).length;
    return { ways: [by_gpu.way, by_wasm.way], grey, differing: by_gpu.pixels.filter((value, i) => value !== by_wasm.pixels[i]).length };
  } },
async ({ result }) => {
  const { ways, grey, differing } = await result;
  assert.deepEqual([ways, differing], [['gpu', 'wasm'], 0]);
  assert.ok(grey > 0.1 * kSize * kSize, `${grey} pixels of the mesh`);
});
