// Cesium's decoder of Draco, with its worker and its WebAssembly file replaced as the README says, decodes as with draco3d.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, readFileSync, rmSync, symlinkSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { page_test } from './browser.mjs';
import { link_package, modules_folder, package_folder, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

link_package();
const { buildSync } = createRequire(path.join(modules_folder, 'package.json'))('esbuild');
const [, stream] = [...streams()].find(([name]) => /11 bits, more attributes/.test(name));
const modules = path.join(modules_folder, 'node_modules'), cesium = path.join(modules, '@cesium/engine');
const [, commands] = readFileSync(path.join(root, 'bindings/web/README.md'), 'utf8').match(/^## Cesium\n.*?^```sh\n(.*?)^```$/ms);

// A project whose page has Cesium's files.
const folder = path.join(root, 'build/web/cesium');
const own = path.join(folder, 'public/cesium'), stock = path.join(folder, 'public/stock');
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
symlinkSync(modules, path.join(folder, 'node_modules'));
for (const copy of [own, stock]) {
  cpSync(path.join(cesium, 'Build'), copy, { recursive: true });
  cpSync(path.join(cesium, 'Source/ThirdParty/draco_decoder.wasm'), path.join(copy, 'ThirdParty/draco_decoder.wasm'));
}
const env = { ...process.env, PATH: `${modules}/.bin:${process.env.PATH}` };
execFileSync('sh', ['-ec', commands], { cwd: folder, env, stdio: 'pipe' });
buildSync({ entryPoints: [path.join(cesium, 'Source/Scene/DracoLoader.js')], bundle: true, format: 'esm', logLevel: 'error',
  outfile: path.join(folder, 'loader.js') });

const decode = async ([attributes, byteLength]) => {
  const { digest } = await import('/page.js');
  const results = [];
  for (const base of ['/cesium/', '/stock/']) {
    globalThis.CESIUM_BASE_URL = new URL(base, location).href;
    const { default: loader } = await import(`/loader.js?${base}`);
    for (const dequantizeInShader of [false, true]) {
      const array = new Uint8Array(await (await fetch('/mesh.drc')).arrayBuffer());
      const options = { array, bufferView: { byteLength }, compressedAttributes: attributes, dequantizeInShader,
        attributesToSkipTransform: ['POSITION', 'NORMAL'] };
      // It returns nothing until its worker is there.
      let decoding;
      while ((decoding = loader.decodeBufferView(options)) === undefined) await new Promise((resolve) => setTimeout(resolve, 20));
      const { indexArray, attributeData } = await decoding;
      const decoded = [await digest(indexArray.typedArray)];
      for (const [name, { array, data }] of Object.entries(attributeData)) decoded.push([name, await digest(array), data]);
      results.push(JSON.stringify(decoded));
    }
  }
  return results;
};
page_test('Cesium decodes as with draco3d', { files: { '/loader.js': { folder: path.join(folder, 'loader.js') },
  '/cesium/': { folder: own }, '/stock/': { folder: stock }, '/mesh.drc': stream }, script: decode,
  argument: [{ POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, stream.length] }, async ({ result, site }) => {
  const [ours, ours_skipped, theirs, theirs_skipped] = await result;
  assert.deepEqual([ours, ours_skipped], [theirs, theirs_skipped]);
  assert.notEqual(ours, ours_skipped);
  assert.ok(site.requests.includes('/cesium/Workers/decodeDraco.js') && site.requests.includes('/stock/Workers/decodeDraco.js'));
  // Each has the WebAssembly file of its own script, and would fail with the other.
  const wasm = (at) => readFileSync(path.join(at, 'draco_decoder.wasm'));
  assert.ok(wasm(path.join(own, 'ThirdParty')).equals(wasm(path.join(package_folder, 'draco'))));
});
