// Several workers of a page decode one container, with and without shared memory.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { page_test } from './browser.mjs';
import { gltf_psplit, make_container, psplit } from './load.mjs';

const skip = gltf_psplit === null && 'there is no gltf-psplit';
const { bytes, attributes } = skip ? {} : make_container(60000, 1500);
const digest = (array) =>
  createHash('sha256').update(new Uint8Array(array.buffer, array.byteOffset, array.byteLength)).digest('hex');
const expected = skip ? null : await psplit.decodeContainer(bytes, { attributes })
  .then(({ indices, attributes: values, patchCount }) =>
    ({ patchCount, digests: [indices, ...values.map(({ array }) => array)].map(digest) }));

const isolation = { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' };
for (const [name, headers, shared, is_shared] of [
  ['without isolation', {}, undefined, false], ['with isolation', isolation, undefined, true],
  ['with isolation, but not shared', isolation, false, false]])
  page_test(`a container ${name}`, { skip, headers, files: skip ? {} : { '/container.bin': bytes },
    argument: { attributes, shared }, script: async ({ attributes, shared }) => {
    const { createPool } = await import('/psplit/index.js'), { digest, fetch_bytes } = await import('/page.js');
    const bytes = await fetch_bytes('/container.bin'), pool = createPool({ workers: 3, shared });
    const digests = (arrays) => Promise.all(arrays.map(digest));
    const arrays_of = ({ indices, attributes }) => [indices, ...attributes.map(({ array }) => array)];
    const jobs = [];
    for (const workers of [1, 2, 3, undefined]) {
      const progress = [];
      const mesh = await pool.decodeContainer(bytes, { attributes, workers, onProgress: (...counts) => progress.push(counts) });
      jobs.push({ patchCount: mesh.patchCount, digests: await digests(arrays_of(mesh)), progress,
        is_shared: arrays_of(mesh).every(({ buffer }) => !(buffer instanceof ArrayBuffer)) });
    }
    // The parts are copied to their places.
    const parts = [];
    const mesh = await pool.decodePatches(bytes, { attributes, workers: 2, onPart: (part) => parts.push(part) });
    const joined = arrays_of(mesh).map((array) => new array.constructor(array.length));
    for (const { firstFace, indices, firstPoint, attributes: values } of parts) {
      joined[0].set(indices, 3 * firstFace);
      values.forEach(({ array, componentCount }, i) => joined[1 + i].set(array, componentCount * firstPoint));
    }
    const result = { jobs, joined: await digests(joined), workers: pool.workerCount };
    pool.dispose();
    return result;
  } }, async ({ result, page }) => {
    const { jobs, joined, workers } = await result;
    for (const [i, { patchCount, digests, progress, is_shared: job_is_shared }] of jobs.entries()) {
      assert.deepEqual({ patchCount, digests }, expected);
      assert.equal(job_is_shared, is_shared && i > 0);  // the first has one worker
      for (const [k, [done, total]] of progress.entries())
        assert.ok(total === expected.patchCount && done > (progress[k - 1]?.[0] ?? 0), JSON.stringify(progress));
      assert.equal(progress.at(-1)[0], expected.patchCount);
    }
    assert.deepEqual(joined, expected.digests);
    assert.equal(workers, 3);
    for (let left = 500; left > 0 && page.workers().length > 0; --left) await new Promise((resolve) => setTimeout(resolve, 20));
    assert.equal(page.workers().length, 0);
  });
