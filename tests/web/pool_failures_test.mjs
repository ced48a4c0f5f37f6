// Pools whose workers die, cannot be started, or are not wanted any more: every promise settles, and no worker is left.
import assert from 'node:assert/strict';
import { createRequire, syncBuiltinESMExports } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { compressed_primitives, psplit, root } from './load.mjs';

// The package's workers, which the tests end. `construct` makes the next ones.
const threads = createRequire(import.meta.url)('node:worker_threads');
const { Worker } = threads, alive = new Set(), up = new Set();
let construct = (...args) => new Worker(...args);
threads.Worker = function (...args) {
  const worker = construct(...args);
  alive.add(worker);
  worker.once('message', () => up.add(worker));
  worker.once('exit', () => alive.delete(worker) && up.delete(worker));
  return worker;
};
syncBuiltinESMExports();

const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/condensed-borders.glb');
const [{ bytes, attributes }] = compressed_primitives(sample, 'PSPLIT_mesh_draco_patches');
const expected = await psplit.decodeContainer(bytes, { attributes });
const until = async (condition) => {
  for (let left = 1000; left > 0 && !condition(); --left) await new Promise((resolve) => setTimeout(resolve, 10));
  assert.ok(condition(), String(condition));
};

// Each test has a pool, and no worker is left after it.
function pool_test(name, options, use) {
  test(name, { timeout: 30000 }, async () => {
    const pool = psplit.createPool(options);
    try {
      await use(pool);
    } finally {
      pool.dispose();
    }
    assert.equal(pool.workerCount, 0);
    await until(() => alive.size === 0);
  });
}
const decode = (pool, options) => pool.decodeContainer(bytes, { attributes, ...options });
const aborted = { name: 'PsplitError', code: 'aborted' }, failed = { name: 'PsplitError', code: 'failed' };

for (const shared of [false, true])
  for (const victim of [0, 1, 2])
    pool_test(`worker ${victim} of three dies${shared ? ' with shared memory' : ''}`, { workers: 3, shared }, async (pool) => {
      await decode(pool, { workers: 3 });
      const [...workers] = alive;
      assert.equal(workers.length, 3);
      const job = decode(pool, { workers: 3 });
      workers[victim].terminate();
      // It may have done its part before it ends.
      await job.then((mesh) => assert.equal(mesh.faceCount, expected.faceCount), (error) => assert.equal(error.code, 'failed'));
      assert.equal((await decode(pool, { workers: 3 })).faceCount, expected.faceCount);
    });

// A worker that starts, and never answers.
const mute = () => new Worker('require("node:worker_threads").parentPort.on("message", () => {})', { eval: true });
// A worker that is up, and then never answers: like one with work without end.
const stuck = () => new Worker(`const { parentPort } = require('node:worker_threads');
  parentPort.on('message', () => {});
  parentPort.postMessage({ is_up: true });`, { eval: true });
const broken = () => new Worker('throw new Error("broken")', { eval: true });
// The first workers are real, as many as `count` says.
async function with_workers(count, make, use) {
  let left = count;
  construct = (...args) => (left-- > 0 ? new Worker(...args) : make());
  try {
    await use();
  } finally {
    construct = (...args) => new Worker(...args);
  }
}

for (const [count, phase] of [[0, 'all decode'], [1, 'the lead waits for its helpers'], [2, 'the lead waits for one helper']])
  for (const end of ['abort', 'dispose', 'death'])
    pool_test(`${end} while ${phase}`, { workers: 3 }, (pool) => with_workers(count, stuck, async () => {
      const controller = new AbortController();
      const job = decode(pool, { workers: 3, signal: controller.signal });
      const rejection = assert.rejects(job, end === 'death' ? failed : aborted);
      await until(() => up.size === 3);
      const other = decode(pool, { workers: 3 });
      construct = (...args) => new Worker(...args);
      if (end === 'abort') controller.abort();
      else if (end === 'dispose') pool.dispose();
      else [...alive].at(-1).terminate();
      await rejection;
      if (end === 'dispose') assert.deepEqual(await other.catch(({ code }) => code), 'aborted');
      else assert.deepEqual(await other, expected);
    }));

for (const end of ['abort', 'dispose'])
  pool_test(`${end} while workers start`, { workers: 2 }, (pool) => with_workers(0, mute, async () => {
    const controller = new AbortController();
    const rejection = assert.rejects(decode(pool, { workers: 2, signal: controller.signal }), aborted);
    await until(() => alive.size === 2);
    if (end === 'abort') controller.abort();
    else pool.dispose();
    await rejection;
  }));

pool_test('fewer workers than wanted', { workers: 4 }, (pool) => with_workers(2, broken, async () => {
  assert.deepEqual(await decode(pool, { workers: 4 }), expected);
  assert.deepEqual(await decode(pool, { workers: 4 }), expected);
  assert.equal(pool.workerCount, 2);
}));
pool_test('no worker at all: this thread decodes', { workers: 2 }, (pool) => with_workers(0, broken, async () => {
  const { warn } = console, warnings = [], progress = [], parts = [];
  console.warn = (text) => warnings.push(text);
  try {
    const meshes = await Promise.all([decode(pool, { workers: 2, onProgress: (...counts) => progress.push(counts) }), decode(pool),
      pool.decodePatches(bytes, { attributes, onPart: (part) => parts.push(part) })]);
    for (const mesh of meshes) assert.deepEqual(mesh, expected);
    assert.equal(pool.workerCount, 0);
    assert.equal(progress.at(-1)[0], progress.at(-1)[1]);
    assert.equal(parts.filter(({ isFinal }) => isFinal).reduce((sum, { indices }) => sum + indices.length / 3, 0), expected.faceCount);
    const controller = new AbortController(), aborts = assert.rejects(decode(pool, { signal: controller.signal }), aborted);
    controller.abort();
    await aborts;
    await assert.rejects(decode(pool, { attributes: [{ ...attributes[0], uniqueId: 99 }] }), { code: 'invalid-input' });
    const thrown = new Error('thrown');
    await assert.rejects(decode(pool, { onProgress: () => { throw thrown; } }), thrown);
    assert.deepEqual(await decode(pool), expected);
  } finally {
    console.warn = warn;
  }
  assert.equal(warnings[0], 'psplit: no worker can be started, so this thread decodes (worker: broken)');
}));
pool_test('this thread is asked only until workers can be started', { workers: 2, idleMs: 20 }, (pool) => with_workers(0, broken, async () => {
  const { warn } = console;
  console.warn = () => {};
  try {
    assert.deepEqual(await decode(pool), expected);
    construct = (...args) => new Worker(...args);
    await new Promise((resolve) => setTimeout(resolve, 100));
    assert.deepEqual(await decode(pool), expected);
    assert.equal(alive.size, 1);
  } finally {
    console.warn = warn;
  }
}));
pool_test('no worker at all, and this thread must not decode', { workers: 2, mainThread: false }, (pool) => with_workers(0, broken, async () => {
  await assert.rejects(decode(pool, { workers: 2 }), { ...failed, message: 'worker: broken' });
  construct = (...args) => new Worker(...args);
  assert.deepEqual(await decode(pool, { workers: 2 }), expected);
}));

pool_test('functions of the caller that throw', { workers: 2 }, async (pool) => {
  const thrown = new Error('thrown');
  const fail = () => {
    throw thrown;
  };
  for (const workers of [1, 2]) {
    await assert.rejects(decode(pool, { workers, onProgress: fail }), thrown);
    await assert.rejects(pool.decodePatches(bytes, { attributes, workers, onPart: fail }), thrown);
  }
  await assert.rejects(pool.decodePatches(bytes, { attributes }), { code: 'invalid-input' });
  for (const workers of [0, 1.5, NaN]) await assert.rejects(decode(pool, { workers }), { code: 'invalid-input' });
  assert.deepEqual(await decode(pool, { workers: 2 }), expected);
});

pool_test('200 jobs have no more workers than the pool', { workers: 3 }, async (pool) => {
  let most = 0;
  const jobs = Array.from({ length: 200 }, (_, i) => decode(pool, { workers: 1 + (i % 3) }).then((mesh) => {
    most = Math.max(most, alive.size, pool.workerCount);
    return mesh;
  }));
  for (const mesh of await Promise.all(jobs)) assert.deepEqual(mesh, expected);
  for (let i = 0; i < 50; ++i) assert.deepEqual(await decode(pool, { workers: 3 }), expected);
  assert.equal(most, 3);
  assert.equal(alive.size, 3);
});
