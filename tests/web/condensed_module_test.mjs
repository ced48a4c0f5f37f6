// psplit_condensed.wasm is loaded when the first container of condensed patches comes, and only then. It decodes all from then on.
// psplit.wasm is loaded when something else comes before.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { page_test } from './browser.mjs';
import { compressed_primitives, package_folder, psplit, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const sample = (name) => compressed_primitives(path.join(samples, `${name}.glb`), 'PSPLIT_mesh_draco_patches')[0];
const plain = sample('patches'), condensed = sample('condensed'), borders = sample('condensed-borders'), [[, stream]] = [...streams()];
const file = (name) => readFileSync(path.join(package_folder, name));
const { configure, createPool, decodeContainer, decodeDraco } = psplit;
const fetch_before = globalThis.fetch;
after(() => configure());

const { Instance } = await import(pathToFileURL(path.join(package_folder, 'instance.js')));
const decode = (name, { bytes, attributes }) => new Instance(new WebAssembly.Module(file(name))).decode_container(bytes, attributes);

test('psplit.wasm refuses condensed patches, and the other module decodes all', () => {
  for (const asset of [condensed, borders])
    assert.throws(() => decode('psplit.wasm', asset), { code: 'unsupported', message: /condensed/ });
  assert.deepEqual(decode('psplit_condensed.wasm', plain), decode('psplit.wasm', plain));
  assert.ok(decode('psplit_condensed.wasm', borders).faceCount > 0);
});

test('one module may be all', async () => {
  configure({ wasm: file('psplit_condensed.wasm'), condensedWasm: 'file:///nowhere/psplit_condensed.wasm' });
  assert.deepEqual(await decodeContainer(condensed.bytes, condensed), decode('psplit_condensed.wasm', condensed));
  const pool = createPool({ workers: 1 });
  try {
    assert.deepEqual(await pool.decodeContainer(condensed.bytes, condensed), decode('psplit_condensed.wasm', condensed));
  } finally {
    pool.dispose();
  }
});

test('without the module, everything else is decoded', async () => {
  configure({ condensedWasm: 'file:///nowhere/psplit_condensed.wasm' });
  const error = { name: 'PsplitError', code: 'failed', message: /psplit_condensed\.wasm cannot be loaded/ }, pool = createPool({ workers: 1 });
  try {
    assert.ok((await decodeContainer(plain.bytes, plain)).faceCount > 0 && (await decodeDraco(stream)).faceCount > 0);
    await assert.rejects(decodeContainer(condensed.bytes, condensed), error);
    await assert.rejects(pool.decodeContainer(condensed.bytes, condensed), error);
    await assert.rejects(pool.decodeStream(new Response(condensed.bytes).body, condensed), error);
    assert.ok((await pool.decodeContainer(plain.bytes, plain)).faceCount > 0);
    await assert.rejects(createPool({ condensedWasm: file('psplit.wasm') }).decodeContainer(condensed.bytes, condensed),
      { code: 'failed', message: 'the WebAssembly module is not psplit_condensed.wasm' });
    configure();  // the next call tries again
    assert.ok((await pool.decodeContainer(condensed.bytes, condensed)).faceCount > 0);
    const { primitives: [{ chosen }] } = await pool.decodeUrl(pathToFileURL(path.join(samples, 'condensed-borders.glb')), { choose: () => [1, 0] });
    assert.deepEqual(chosen, Uint32Array.of(1, 0));
  } finally {
    pool.dispose();
  }
});

test('jobs of both kinds on the same workers', async () => {
  configure();
  const pool = createPool({ workers: 2 }), all = [plain, condensed, borders], expected = all.map((asset) => decode('psplit_condensed.wasm', asset));
  try {
    for (let i = 0; i < 3; ++i) {
      const meshes = await Promise.all([...all, ...all].map(({ bytes, attributes }, n) => (n % 2 ? pool.decodeStream(new Response(bytes).body, { attributes })
        : pool.decodeContainer(bytes, { attributes, workers: 2 }))));
      assert.deepEqual(meshes, [...expected, ...expected]);
      assert.ok((await pool.decodeDraco(stream)).faceCount > 0);
    }
    const given = condensed.bytes.slice(), job = pool.decodeContainer(given, { ...condensed, transfer: true });
    assert.deepEqual(await job, expected[1]);
    assert.equal(given.length, 0);
    // A buffer that is transferred while the module is being loaded.
    const moved = condensed.bytes.slice(), late = pool.decodeContainer(moved, condensed);
    structuredClone(moved.buffer, { transfer: [moved.buffer] });
    await assert.rejects(late, { code: 'invalid-input', message: /transferred elsewhere/ });
  } finally {
    pool.dispose();
  }
});

test('a job ends while the module is being loaded', async () => {
  configure();
  for (const end of [(pool, stop) => stop.abort(), (pool) => pool.dispose()]) {
    const pool = createPool({ workers: 1, condensedWasm: 'http://127.0.0.1:9/' }), stop = new AbortController();
    globalThis.fetch = () => new Promise(() => {});  // a server that does not answer
    try {
      const job = pool.decodeContainer(condensed.bytes, { ...condensed, signal: stop.signal });
      setTimeout(end, 20, pool, stop);
      await assert.rejects(job, { code: 'aborted' });
    } finally {
      globalThis.fetch = fetch_before;
      pool.dispose();
    }
  }
});

test('the module that decodes all comes first', async () => {
  const asked = [], wasm = (name) => new Response(file(name), { headers: { 'Content-Type': 'application/wasm' } });
  globalThis.fetch = async (url) => (asked.push(path.basename(url.pathname)), wasm(asked.at(-1)));
  const at = (name) => `http://127.0.0.1/${name}`, addresses = { condensedWasm: at('psplit_condensed.wasm') }, pools = [];
  const make_pool = (options) => (pools.push(createPool({ workers: 1, ...options })), pools.at(-1));
  try {
    configure(addresses);
    await decodeContainer(condensed.bytes, condensed);
    await Promise.all([decodeDraco(stream), decodeContainer(plain.bytes, plain), make_pool().decodeDraco(stream)]);
    assert.deepEqual(asked.splice(0), ['psplit_condensed.wasm']);
    // A pool that has its own.
    const pool = make_pool(addresses);
    await pool.ready({ condensed: true });
    await Promise.all([pool.decodeDraco(stream), pool.decodeContainer(condensed.bytes, condensed), pool.decodeContainer(condensed.bytes, condensed)]);
    assert.deepEqual(asked.splice(0), ['psplit_condensed.wasm']);
    // A module that the caller named is asked first.
    const given = make_pool({ ...addresses, wasm: at('psplit.wasm') });
    await given.decodeContainer(condensed.bytes, condensed);
    assert.deepEqual(asked.splice(0), ['psplit.wasm', 'psplit_condensed.wasm']);
  } finally {
    globalThis.fetch = fetch_before;
    pools.forEach((pool) => pool.dispose());
    configure();
  }
});

test('workers start while the module is loaded', async () => {
  let answer;
  globalThis.fetch = () => new Promise((resolve) => (answer = resolve));
  configure();
  const pool = createPool({ workers: 1, condensedWasm: 'http://127.0.0.1/psplit_condensed.wasm' });
  try {
    const job = pool.decodeContainer(condensed.bytes, condensed);
    while (pool.workerCount === 0) await new Promise((resolve) => setTimeout(resolve, 1));
    answer(new Response(file('psplit_condensed.wasm'), { headers: { 'Content-Type': 'application/wasm' } }));
    assert.ok((await job).faceCount > 0);
  } finally {
    globalThis.fetch = fetch_before;
    pool.dispose();
  }
});

page_test('a page loads it when it needs it', { files: Object.fromEntries(['patches', 'condensed'].map((name) =>
  [`/${name}.glb`, { folder: path.join(samples, `${name}.glb`) }])), script: async () => {
  const { createPool } = await import('/psplit/index.js'), { decodeGltf } = await import('/psplit/asset.js'), pool = createPool({ workers: 2 });
  const counts = [];
  globalThis.load = async (name) => {
    const asset = await decodeGltf(`/${name}.glb`, { pool }), { length } = (await decodeGltf(`/${name}.glb`)).primitives[0].indices;
    return [asset.primitives[0].indices.length, length];
  };
  counts.push(await globalThis.load('patches'));
  return counts;
} }, async ({ result, page, site }) => {
  const [counts] = await result, wasm = () => site.requests.filter((url) => url.endsWith('.wasm'));
  assert.equal(new Set(counts).size, 1);
  assert.deepEqual(wasm(), ['/psplit/psplit.wasm']);
  assert.equal(new Set(await page.evaluate(() => globalThis.load('condensed'))).size, 1);
  assert.deepEqual(wasm(), ['/psplit/psplit.wasm', '/psplit/psplit_condensed.wasm']);
});

page_test('a page of condensed patches loads one module', { files: { '/condensed.glb': { folder: path.join(samples, 'condensed.glb') } },
  script: async () => {
    const { createPool, decodeDraco } = await import('/psplit/index.js'), pool = createPool({ workers: 2 });
    const { primitives: [{ faceCount }] } = await pool.decodeUrl('/condensed.glb'), none = new Uint8Array(12);
    return [faceCount, ...await Promise.all([decodeDraco(none), pool.decodeDraco(none)].map((job) => job.catch(({ code }) => code)))];
  } }, async ({ result, site }) => {
  const [face_count, ...codes] = await result;
  assert.ok(face_count > 0);
  assert.deepEqual(codes, ['invalid-input', 'invalid-input']);
  assert.deepEqual(site.requests.filter((url) => url.endsWith('.wasm')), ['/psplit/psplit_condensed.wasm']);
});
