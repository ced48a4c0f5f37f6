// Pools: the same results as without workers, and every promise settles.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { compressed_primitives, package_folder, psplit, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb');
const [{ bytes, attributes }] = compressed_primitives(sample, 'PSPLIT_mesh_draco_patches');
const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const containers = readdirSync(samples).filter((name) => name.endsWith('.glb'))
  .flatMap((name) => compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches').map((primitive) => ({ name, ...primitive })));
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

// Shared arrays become plain ones, so that both are compared.
const plain_arrays = ({ indices, attributes, ...rest }) => ({ ...rest, indices: Uint32Array.from(indices),
  attributes: attributes.map((attribute) => ({ ...attribute, array: attribute.array.constructor.from(attribute.array) })) });

for (const shared of [false, true])
  test(`several workers decode what one decodes, ${shared ? 'in shared memory' : 'by transfer'}`, () => with_pool({ workers: 4, shared }, async (pool) => {
    assert.ok(containers.length > 7);
    for (const { name, bytes, attributes } of containers) {
      const expected = await psplit.decodeContainer(bytes, { attributes });
      for (const workers of [2, 3, 4]) {
        const mesh = await pool.decodeContainer(bytes, { attributes, workers });
        const is_several = Math.min(workers, mesh.firstFaces.length - 1) > 1;
        assert.equal(mesh.indices.buffer instanceof SharedArrayBuffer, shared && is_several, name);
        assert.deepEqual(plain_arrays(mesh), expected, name);
      }
    }
    assert.equal(pool.workerCount, 4);
  }));

test('parts are the mesh, and progress is complete', () => with_pool({ workers: 3 }, async (pool) => {
  for (const { name, bytes, attributes } of containers)
    for (const workers of [1, 2, 3]) {
      const parts = [], progress = [];
      const mesh = await pool.decodePatches(bytes, { attributes, workers, onPart: (part, counts) => parts.push([part, counts]),
        onProgress: (...counts) => progress.push(counts) });
      assert.deepEqual(mesh, await psplit.decodeContainer(bytes, { attributes }));
      check_parts(parts.map(([part]) => part), mesh, name);
      const { firstFaces, firstPoints, indices, attributes: arrays, ...counts } = mesh;
      for (const [, of_part] of parts) assert.deepEqual(of_part, counts);
      const total = mesh.firstFaces.length - 1;
      assert.ok(progress.every(([done, of], i) => of === total && done > (i === 0 ? 0 : progress[i - 1][0])), String(progress));
      assert.equal(progress.at(-1)[0], total);
    }
}));

// Each part is a slice of the mesh, and refers to no point that comes later. Faces of parts that are not final may be
// degenerate.
function check_parts(parts, mesh, name) {
  const has_come = new Uint8Array(mesh.pointCount), final_count = new Uint8Array(mesh.firstFaces.length - 1);
  for (const { patches: [first, end], isFinal, firstFace, indices, firstPoint, pointCount, attributes } of parts) {
    if (isFinal) for (let i = first; i < end; ++i) ++final_count[i];
    assert.equal(firstFace, mesh.firstFaces[first]);
    assert.equal(firstPoint, mesh.firstPoints[first]);
    assert.equal(firstPoint + pointCount, mesh.firstPoints[end]);
    const expected = mesh.indices.slice(3 * firstFace, 3 * mesh.firstFaces[end]);
    for (let at = 0; !isFinal && at < indices.length; at += 3)
      if (indices.subarray(at, at + 3).every((index) => index === 0)) expected.fill(0, at, at + 3);
    assert.deepEqual(Uint32Array.from(indices), expected);
    for (const [i, { array, ...attribute }] of attributes.entries()) {
      const { array: whole, ...expected } = mesh.attributes[i], { componentCount } = expected;
      assert.deepEqual(attribute, expected);
      assert.deepEqual(array, whole.slice(componentCount * firstPoint, componentCount * (firstPoint + pointCount)));
    }
    has_come.fill(1, firstPoint, firstPoint + pointCount);
    for (let at = 0; at < indices.length; at += 3)
      if (isFinal || indices[at] + indices[at + 1] + indices[at + 2] > 0)
        assert.ok(has_come[indices[at]] & has_come[indices[at + 1]] & has_come[indices[at + 2]], `${name}: a part refers to a later one`);
  }
  assert.ok(final_count.every((count) => count === 1), `${name}: a patch is not final once`);
}

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
