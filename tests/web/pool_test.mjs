// Pools: the same results as without workers, and every promise settles.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { compressed_primitives, package_folder, psplit, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb');
const [{ bytes, attributes }] = compressed_primitives(sample, 'PSPLIT_mesh_draco_patches');
const all_streams = [...streams()].map(([, stream]) => stream);

async function with_pool(options, use) {
  const pool = psplit.createPool(options);
  try {
    await use(pool);
  } finally {
    pool.dispose();
  }
}

test('results are those of the calling thread', () => with_pool({ workers: 2 }, async (pool) => {
  const meshes = await Promise.all(all_streams.map((stream) => pool.decodeDraco(stream)));
  for (const [i, mesh] of meshes.entries()) assert.deepEqual(mesh, await psplit.decodeDraco(all_streams[i]));
  assert.deepEqual(await pool.decodeContainer(bytes, { attributes }), await psplit.decodeContainer(bytes, { attributes }));
  assert.equal(pool.workerCount, 2);
}));

test('errors have code and patch', () => with_pool({ workers: 1 }, async (pool) => {
  const broken = Uint8Array.from(bytes);
  broken.fill(0xff, bytes.length - 60);
  const error = await psplit.decodeContainer(broken, { attributes }).catch((cause) => cause);
  await assert.rejects(pool.decodeContainer(broken, { attributes }),
    { name: 'PsplitError', code: error.code, patch: error.patch, message: error.message });
  await assert.rejects(pool.decodeDraco('text'), { code: 'invalid-input' });
  await pool.decodeDraco(all_streams[0]);  // goes on
}));

test('the data is transferred only if the caller allows it', () => with_pool({ workers: 1 }, async (pool) => {
  const data = Uint8Array.from(all_streams[0]);
  await pool.decodeDraco(data);
  assert.ok(data.length > 0);
  await pool.decodeDraco(data, { transfer: true });
  assert.equal(data.length, 0);
}));

test('abort', () => with_pool({ workers: 1 }, async (pool) => {
  const aborted = { name: 'PsplitError', code: 'aborted' };
  await assert.rejects(pool.decodeDraco(all_streams[0], { signal: AbortSignal.abort() }), aborted);
  const controllers = Array.from({ length: 20 }, () => new AbortController());
  const jobs = controllers.map(({ signal }) => pool.decodeContainer(bytes, { attributes, signal }));
  const last = pool.decodeDraco(all_streams[0]);
  const settled = Promise.allSettled(jobs);
  for (const controller of controllers) controller.abort();
  for (const { reason } of await settled) assert.equal(reason.code, 'aborted');
  assert.ok((await last).faceCount > 0);
}));

test('dispose', async () => {
  const pool = psplit.createPool({ workers: 2 });
  const jobs = Promise.allSettled(all_streams.map((stream) => pool.decodeDraco(stream)));
  pool.dispose();
  for (const { reason } of await jobs) assert.equal(reason.code, 'aborted');
  await assert.rejects(pool.decodeDraco(all_streams[0]), { code: 'aborted' });
  assert.equal(pool.workerCount, 0);
});

test('workers end when they are idle', () => with_pool({ workers: 2, idleMs: 20 }, async (pool) => {
  for (let round = 0; round < 3; ++round) {
    await Promise.all([0, 1].map((i) => pool.decodeDraco(all_streams[i])));
    for (let left = 200; left > 0 && pool.workerCount > 0; --left) await new Promise((resolve) => setTimeout(resolve, 10));
    assert.equal(pool.workerCount, 0);
  }
}));

test('a module that is not one', async () => {
  for (const wasm of [new Uint8Array([0, 97, 115, 109]), 'file:///nowhere/psplit.wasm'])
    await with_pool({ wasm }, async (pool) => {
      await assert.rejects(pool.ready(), { name: 'PsplitError', code: 'failed' });
      await assert.rejects(pool.decodeDraco(all_streams[0]), { name: 'PsplitError', code: 'failed' });
    });
  assert.throws(() => psplit.createPool({ workers: 0 }), { code: 'invalid-input' });
});

test('the module as bytes, and compiled', async () => {
  const wasm = readFileSync(path.join(package_folder, 'psplit.wasm'));
  for (const given of [wasm, await WebAssembly.compile(wasm)])
    await with_pool({ wasm: given, workers: 1 }, async (pool) => assert.ok((await pool.decodeDraco(all_streams[0])).faceCount > 0));
});
