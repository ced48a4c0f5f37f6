// configure(): the package where it cannot fetch the files beside its code. In a runtime like those at the edge of networks,
// with compiled modules and without workers; in Node.js; and in pages that have the files elsewhere.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test, { afterEach } from 'node:test';
import { pathToFileURL } from 'node:url';
import vm from 'node:vm';
import { Worker } from 'node:worker_threads';
import { page_test, start_site } from './browser.mjs';
import { compressed_primitives, modules_folder, package_folder, psplit, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const { build } = createRequire(path.join(modules_folder, 'package.json'))('esbuild');
const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb');
const [{ bytes, attributes }] = compressed_primitives(sample, 'PSPLIT_mesh_draco_patches'), [[, stream]] = [...streams()];
const wasm = readFileSync(path.join(package_folder, 'psplit.wasm'));
const expected = await psplit.decodeContainer(bytes, { attributes });
afterEach(() => psplit.configure({}));

// A bundle of the package in a context that has what such runtimes have: they compile no bytes, and know no file beside the code.
async function edge_runtime(globals = {}) {
  const { outputFiles: [{ text }] } = await build({ entryPoints: [path.join(package_folder, 'index.js')], bundle: true, format: 'iife',
    globalName: 'psplit', write: false, logLevel: 'silent' });
  const { Module, Instance, Memory, RuntimeError, CompileError } = WebAssembly;
  const context = vm.createContext({ ArrayBuffer, TextDecoder, TextEncoder, URL, performance, setTimeout, clearTimeout, queueMicrotask,
    console: { warn() {} }, ...globals });
  vm.runInContext('delete globalThis.WebAssembly', context);
  context.WebAssembly = { Module, Instance, Memory, RuntimeError, CompileError };
  vm.runInContext(text, context);
  return vm.runInContext('psplit', context);
}
// Objects of a context have other prototypes.
const plain = (mesh) => structuredClone(mesh);

test('an edge runtime', async () => {
  const edge = await edge_runtime();
  await assert.rejects(edge.decodeDraco(stream), ({ name, code }) => name === 'PsplitError' && code === 'failed');
  edge.configure({ wasm: new WebAssembly.Module(wasm) });
  assert.deepEqual(plain(await edge.decodeContainer(bytes, { attributes })), expected);
  assert.equal((await edge.decodeDraco(stream)).faceCount, (await psplit.decodeDraco(stream)).faceCount);
  const pool = edge.createPool();
  assert.deepEqual(plain(await pool.decodeContainer(bytes, { attributes })), expected);
  pool.dispose();
});

test('Node.js', async () => {
  psplit.configure({ wasm: 'file:///nowhere/psplit.wasm' });
  await assert.rejects(psplit.decodeDraco(stream), { code: 'failed', message: /^file:\/\/\/nowhere/ });
  psplit.configure({ wasm });
  assert.deepEqual(await psplit.decodeContainer(bytes, { attributes }), expected);
  let count = 0;
  const address = pathToFileURL(path.join(package_folder, 'worker.js'));
  for (const worker of [address, address.href, () => ++count && new Worker(address)]) {
    psplit.configure({ worker });
    const pool = psplit.createPool({ workers: 1, mainThread: false });
    assert.deepEqual(await pool.decodeContainer(bytes, { attributes }), expected);
    pool.dispose();
  }
  assert.equal(count, 1);
  psplit.configure({ worker: 'file:///nowhere/worker.js' });
  const pool = psplit.createPool({ workers: 1, mainThread: false });
  await assert.rejects(pool.decodeDraco(stream), { code: 'failed' });
  pool.dispose();
  psplit.configure(null);
  assert.ok((await psplit.decodeDraco(stream)).faceCount > 0);
});

// The code is on another origin, which pages' workers cannot be from.
page_test('a page with the worker on its own origin', { errors: [/nowhere\.js|404/] }, async ({ page }) => {
  const other = await start_site({ headers: { 'Access-Control-Allow-Origin': '*' } });
  try {
    const outcomes = await page.evaluate(async ({ origin, stream }) => {
      const { configure, createPool } = await import(`${origin}/psplit/index.js`), { bytes_of_text, outcome } = await import('/page.js');
      const outcomes = [];
      for (const worker of ['/psplit/worker.js', () => new Worker('/psplit/worker.js', { type: 'module' }), '/nowhere.js']) {
        configure({ worker });
        const pool = createPool({ workers: 1, mainThread: false });
        outcomes.push(await outcome(pool.decodeDraco(bytes_of_text(stream))));
        pool.dispose();
      }
      return outcomes;
    }, { origin: other.origin, stream: Buffer.from(stream).toString('base64') });
    assert.deepEqual(outcomes.slice(0, 2), ['done', 'done']);
    assert.match(outcomes[2].message, /^worker: http:.*\/nowhere\.js cannot be loaded$/);
  } finally {
    other.close();
  }
});
