// A page keeps nothing after the work, however that ends: no workers, memory of WebAssembly, arrays or objects.
import assert from 'node:assert/strict';
import path from 'node:path';
import { page_test } from './browser.mjs';
import { compressed_primitives, gltf_psplit, make_container, root } from './load.mjs';
import { encode, grid, streams } from './stock_draco.mjs';

const all = [...streams()].map(([, bytes]) => bytes);
// Several workers decode the container, if there is a tool to make a large one.
const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb');
const { bytes: container, attributes } = gltf_psplit !== null ? make_container(40000, 1500)
  : compressed_primitives(sample, 'PSPLIT_mesh_draco_patches')[0];
const files = { ...Object.fromEntries(all.map((bytes, i) => [`/${i}.drc`, bytes])), '/container.bin': container };
const jobs_in_all = all.length + 1;
const argument = { count: all.length, attributes };
const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Sets globalThis.psplit and globalThis.jobs in the page. Jobs are functions that decode with a pool, or with the package itself.
async function prepare({ count, attributes }) {
  const psplit = await import('/psplit/index.js'), { fetch_bytes } = await import('/page.js');
  const streams = await Promise.all(Array.from({ length: count }, (_, i) => fetch_bytes(`/${i}.drc`)));
  const container = await fetch_bytes('/container.bin');
  const jobs = [...streams.map((bytes) => (decoder, options) => decoder.decodeDraco(bytes, options)),
    (decoder, options) => decoder.decodeContainer(container, { attributes, ...options })];
  Object.assign(globalThis, { psplit, jobs });
}

// Returns the bytes of objects, of arrays, and of WebAssembly memories in a page or a worker, after a garbage collection.
async function held_by(session) {
  const { result: { objectId: prototypeObjectId } } =
    await session.send('Runtime.evaluate', { expression: 'WebAssembly.Memory.prototype' });
  const { objects: { objectId } } = await session.send('Runtime.queryObjects', { prototypeObjectId });
  const { result: { value: wasm } } = await session.send('Runtime.callFunctionOn', { objectId, returnByValue: true,
    functionDeclaration: 'function () { return this.reduce((sum, memory) => sum + memory.buffer.byteLength, 0); }' });
  for (const id of [prototypeObjectId, objectId]) await session.send('Runtime.releaseObject', { objectId: id });
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize, backingStorageSize } = await session.send('Runtime.getHeapUsage');
  return { objects: usedSize, arrays: backingStorageSize, wasm };
}
async function held(page) {
  const session = await page.createCDPSession();
  try {
    return await held_by(session);
  } finally {
    await session.detach();
  }
}
const held_by_workers = (page) => Promise.all(page.workers().map((worker) => held_by(worker.client)));
function check_same(after, before, more_wasm = 0) {
  const grown = Object.fromEntries(Object.keys(before).map((name) => [name, after[name] - before[name]]));
  assert.ok(grown.objects < 50000 && grown.arrays < 10000 && grown.wasm <= more_wasm, JSON.stringify({ before, after }));
}

// Checks how many workers the DevTools protocol counts. It knows of a start or an end a moment later.
async function check_workers(page, count) {
  for (let left = 500; left > 0 && page.workers().length !== count; --left) await wait(20);
  assert.equal(page.workers().length, count);
}

const page_of = (name, check, options) => page_test(name, { files, argument, script: prepare, ...options }, async (of) => {
  await of.result;
  await check(of.page);
});

const isolation = { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' };
for (const [name, headers] of [['200 loads in a pool', {}], ['200 loads in a pool with shared memory', isolation]])
  page_of(name, async (page) => {
    await page.evaluate(() => { globalThis.pool = psplit.createPool({ workers: 2, idleMs: 60000 }); });
    const load = (loads) => page.evaluate(async (loads) => {
      for (let done = 0; done < loads; done += 20) {
        await Promise.all(Array.from({ length: 19 }, (_, i) => jobs[(2 * done + i) % jobs.length](pool)));
        await jobs.at(-1)(pool);  // alone: it has all workers
      }
    }, loads);
    await load(200);  // code is compiled
    await check_workers(page, 2);
    const before = await held(page), of_workers = await held_by_workers(page);
    await load(200);
    assert.equal(page.workers().length, 2);
    // Which worker has which job differs, and so does the size of its memory.
    for (const [i, of_worker] of (await held_by_workers(page)).entries()) check_same(of_worker, of_workers[i], 2 ** 20);
    check_same(await held(page), before);
    await page.evaluate(() => pool.dispose());
    await check_workers(page, 0);
    check_same(await held(page), before);
  }, { headers });

page_of('idle workers end, and come back', async (page) => {
  await page.evaluate(() => { globalThis.pool = psplit.createPool({ workers: 2, idleMs: 100 }); });
  for (let round = 0; round < 3; ++round) {
    await page.evaluate(() => Promise.all(jobs.slice(0, 4).map((job) => job(pool))));
    await check_workers(page, 0);
  }
});

page_of('200 loads on the calling thread', async (page) => {
  const load = (loads) => page.evaluate(async (loads) => {
    for (let i = 0; i < loads; ++i) await jobs[i % jobs.length](psplit);
  }, loads);
  await load(3 * jobs_in_all);
  const before = await held(page);
  assert.ok(before.wasm > 0);
  await load(200);
  check_same(await held(page), before);
});
page_of('50 pools', async (page) => {
  const load = (pools) => page.evaluate(async (pools) => {
    for (let i = 0; i < pools; ++i) {
      const pool = psplit.createPool({ workers: 2 });
      await Promise.all([jobs[0](pool), jobs.at(-1)(pool)]);
      pool.dispose();
    }
  }, pools);
  await load(10);
  const before = await held(page);
  await load(50);
  await check_workers(page, 0);
  check_same(await held(page), before);
});

page_of('two pools side by side', async (page) => {
  const counts = await page.evaluate(async () => {
    const pools = [1, 2].map((workers) => psplit.createPool({ workers }));
    const meshes = await Promise.all(pools.flatMap((pool) => jobs.map((job) => job(pool))));
    const counts = pools.map((pool) => pool.workerCount);
    pools[0].dispose();
    await jobs[0](pools[1]);
    globalThis.last = pools[1];
    return { counts, meshes: meshes.length,
      same: meshes.every(({ faceCount }, i) => faceCount === meshes[i % jobs.length].faceCount) };
  });
  assert.deepEqual(counts, { counts: [1, 2], meshes: 2 * jobs_in_all, same: true });
  await check_workers(page, 2);
  await page.evaluate(() => last.dispose());
  await check_workers(page, 0);
});

page_of('abort and dispose', async (page) => {
  const codes = await page.evaluate(async () => {
    const codes = new Set();
    const settle = (promises) =>
      Promise.all(promises.map((promise) => promise.then(() => codes.add('done'), ({ code }) => codes.add(code))));
    for (let round = 0; round < 10; ++round) {
      const pool = psplit.createPool({ workers: 2 }), controller = new AbortController();
      const aborted = settle(jobs.map((job) => job(pool, { signal: controller.signal })));
      setTimeout(() => controller.abort(), 3 * round);
      await aborted;
      const alone = new AbortController(), last = settle([jobs.at(-1)(pool, { signal: alone.signal })]);
      setTimeout(() => alone.abort(), 3 * round);
      await last;
      const disposed = settle(jobs.map((job) => job(pool)));
      setTimeout(() => pool.dispose(), 3 * round);
      await disposed;
    }
    return [...codes].filter((code) => code !== 'done');
  });
  assert.deepEqual(codes, ['aborted']);
  await check_workers(page, 0);
});

page_of('a page that goes away while its workers work', async (page) => {
  const start = () => page.evaluate(async () => {
    globalThis.pool = psplit.createPool({ workers: 2 });
    await jobs[0](pool);
    for (let i = 0; i < 10; ++i) for (const job of jobs) job(pool);
  });
  await start();
  await check_workers(page, 2);
  await page.reload();
  await page.evaluate(() => globalThis.result);
  await check_workers(page, 0);
  await start();
  await page.goto('about:blank');
  await check_workers(page, 0);
});

const large = encode(grid(800), { method: 'edgebreaker', speed: 10, bits: 11 });
page_of('the memory of a large mesh is given back', async (page) => {
  const decode = () => page.evaluate(async () => {
    const bytes = new Uint8Array(await (await fetch('/large.drc')).arrayBuffer());
    return (await psplit.decodeDraco(bytes)).faceCount;
  });
  assert.ok((await decode()) > 1000000);
  assert.ok((await held(page)).wasm > 64 * 2 ** 20);
  let wasm, arrays;
  for (let left = 10; left > 0 && !(wasm < 2 ** 20); --left) {
    await wait(1000);
    ({ wasm, arrays } = await held(page));
  }
  assert.ok(wasm < 2 ** 20 && arrays < 2 ** 20, `${wasm} and ${arrays} bytes`);
  await decode();
}, { files: { ...files, '/large.drc': large } });
