// psplit/webgpu in Chromium, on a processor: the same results as WebAssembly's, and a page that draws them.
import assert from 'node:assert/strict';
import { fileURLToPath } from 'node:url';
import { page_test } from './browser.mjs';
import { gltf_psplit, make_container } from './load.mjs';

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
  assert.deepEqual({ equal, by_wasm, differences }, { equal: 1, by_wasm: 1, differences: [] });
});
