// The corpus in three's GLTFLoader: patches by the plugin, and Draco streams by PsplitDracoLoader, have the arrays that
// gltf-psplit decodes.
import assert from 'node:assert/strict';
import { execFile, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { promisify } from 'node:util';
import { scene_differences } from './compare_scenes.mjs';
import { corpus_folder, files_below, psplit, read_asset, root } from './load.mjs';
import { buffer_of, make_loader, PsplitDracoLoader } from './three_loaders.mjs';

const run = promisify(execFile);
const native = [process.env.PSPLIT, path.join(root, 'build/release/gltf-psplit')].find((file) => file !== undefined && existsSync(file));
const skip = (corpus_folder === null && 'there is no corpus') || (native === undefined && 'there is no gltf-psplit');
const folder = path.join(root, 'build/web/corpus');

// Encodes the corpus, and decodes it again: [name, encoded file, plain file]. The files are GLBs with all their buffers.
async function encoded_corpus(kind, options) {
  const gltf = path.join(corpus_folder, 'gltf'), out = path.join(folder, kind), plain = path.join(folder, `${kind}.plain`);
  rmSync(out, { recursive: true, force: true });
  spawnSync(native, ['batch', '-q', '-o', out, '--base', gltf, '--images', 'reference', '--report', path.join(folder, `${kind}.json`),
    ...options, path.join(gltf, '**/*.glb'), path.join(gltf, '**/*.gltf')]);
  const pairs = files_below(out, /\.glb$/).map((file) => [path.relative(out, file), file, path.join(plain, path.relative(out, file))]);
  for (const [, , file] of pairs) mkdirSync(path.dirname(file), { recursive: true });
  for (let next = 0; next < pairs.length; next += 4)
    await Promise.all(pairs.slice(next, next + 4).map(([, from, to]) => run(native, ['decode', '-q', '--images', 'reference', from, to])));
  return pairs;
}

async function check_corpus(pairs, make) {
  let count = 0;
  for (const [name, encoded, plain] of pairs) {
    // GLTFLoader takes only the first buffer of a GLB from the file; others without a URI never settle.
    if (read_asset(encoded).json.buffers?.slice(1).some(({ uri }) => uri === undefined)) continue;
    const load = (loader, file) => loader.parseAsync(buffer_of(readFileSync(file)), '');
    const loaded = await load(make(), encoded).catch((error) => assert.fail(`${name}: ${error.stack}`));
    await loaded.psplit?.whole;
    assert.deepEqual(await scene_differences(await load(make_loader(), plain), loaded), [], name);
    ++count;
  }
  assert.ok(count > 150, `${count} assets`);
}

test('patches of the corpus', { skip }, async () => {
  const pool = psplit.createPool({ workers: 2 });
  try {
    await check_corpus(await encoded_corpus('patches', ['--patches', '6', '--always-patches']), () => make_loader({ plugin: { pool } }));
    await check_corpus(await encoded_corpus('condensed', ['--patches', '6', '--always-patches', '--condense']),
      () => make_loader({ plugin: { pool, patchByPatch: true } }));
  } finally {
    pool.dispose();
  }
});

test('Draco streams of the corpus', { skip }, async () => {
  const draco = new PsplitDracoLoader().setWorkerLimit(2);
  try {
    await check_corpus(await encoded_corpus('draco', ['--patches', '1', '--min-faces', '4294967295']), () => make_loader({ draco }));
  } finally {
    draco.dispose();
  }
});
