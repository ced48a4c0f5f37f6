// The corpus in three's GLTFLoader has the arrays that gltf-psplit decodes: patches and Draco streams by the plugin, and Draco streams
// by DRACOLoader with psplit/draco, in Node.js and in Chromium.
import assert from 'node:assert/strict';
import { execFile, spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync, rmSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { page_test } from './browser.mjs';
import { scene_differences } from './compare_scenes.mjs';
import { corpus_folder, files_below, gltf_psplit, psplit, read_asset, root } from './load.mjs';
import { buffer_of, make_loader } from './three_loaders.mjs';

const run = promisify(execFile);
const skip = (corpus_folder === null && 'there is no corpus') || (gltf_psplit === null && 'there is no gltf-psplit');
const folder = path.join(root, 'build/web/corpus');

const kKinds = { patches: ['--patches', '6', '--always-patches'], condensed: ['--patches', '6', '--always-patches', '--condense'],
  draco: ['--patches', '1', '--min-faces', '4294967295'] };

// Encodes the corpus to KIND/ and decodes it again to KIND.plain/, as GLBs that have all their buffers. Returns their names.
async function encode_corpus(kind) {
  const gltf = path.join(corpus_folder, 'gltf'), out = path.join(folder, kind), plain = path.join(folder, `${kind}.plain`);
  rmSync(out, { recursive: true, force: true });
  spawnSync(gltf_psplit, ['batch', '-q', '-o', out, '--base', gltf, '--images', 'reference', '--report', path.join(folder, `${kind}.json`),
    ...kKinds[kind], path.join(gltf, '**/*.glb'), path.join(gltf, '**/*.gltf')]);
  // GLTFLoader takes only the first buffer of a GLB from the file. It never settles if others have no URI.
  const names = files_below(out, /\.glb$/).filter((file) => !read_asset(file).json.buffers?.slice(1).some(({ uri }) => uri === undefined))
    .map((file) => path.relative(out, file));
  for (const name of names) mkdirSync(path.dirname(path.join(plain, name)), { recursive: true });
  for (let next = 0; next < names.length; next += 4)
    await Promise.all(names.slice(next, next + 4).map((name) =>
      run(gltf_psplit, ['decode', '-q', '--images', 'reference', path.join(out, name), path.join(plain, name)])));
  assert.ok(names.length > 150, `${names.length} assets`);
  return names;
}
const corpus = {};
if (skip === false) for (const kind of Object.keys(kKinds)) corpus[kind] = await encode_corpus(kind);

async function check_corpus(kind, make) {
  const load = (loader, file) => loader.parseAsync(buffer_of(readFileSync(path.join(folder, file))), '');
  for (const name of corpus[kind]) {
    const loaded = await load(make(), `${kind}/${name}`).catch((error) => assert.fail(`${name}: ${error.stack}`));
    await loaded.psplit?.whole;
    assert.deepEqual(await scene_differences(await load(make_loader(), `${kind}.plain/${name}`), loaded), [], name);
  }
}

for (const [kind, patchByPatch] of [['patches', false], ['condensed', true]])
  test(`the corpus in ${kind}${patchByPatch ? ', patch by patch' : ''}`, { skip }, async () => {
    const pool = psplit.createPool({ workers: 2 });
    try {
      await check_corpus(kind, () => make_loader({ plugin: { pool, patchByPatch } }));
    } finally {
      pool.dispose();
    }
  });

test('the corpus in stock Draco', { skip }, async () => {
  const pool = psplit.createPool({ workers: 2 });
  try {
    await check_corpus('draco', () => make_loader({ plugin: { pool } }));
  } finally {
    pool.dispose();
  }
});

const kImports = { three: '/modules/three/build/three.module.js', 'three/addons/': '/modules/three/examples/jsm/' };
const page = `<!doctype html><script type="importmap">${JSON.stringify({ imports: kImports })}</script>
  <script type="module" src="/main.js"></script>`;

// In a page: the assets that are not as they are without compression, and in what.
async function compare_corpus({ kind, names }) {
  const { MeshStandardMaterial } = await import('three'), { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
  const { DRACOLoader } = await import('three/addons/loaders/DRACOLoader.js');
  const { MeshoptDecoder } = await import('three/addons/libs/meshopt_decoder.module.js');
  const { createPool } = await import('/psplit/index.js'), { PsplitPlugin } = await import('/psplit/three.js');
  const { plain_materials, scene_differences: differences } = await import('/compare_scenes.mjs');
  const pool = createPool({ workers: 2 }), draco = new DRACOLoader().setDecoderPath('/psplit/draco/').setWorkerLimit(2);
  const load = async (url) => {
    const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).register(plain_materials(MeshStandardMaterial));
    loader.register((parser) => new PsplitPlugin(parser, { pool, dracoLoader: draco }));
    return loader.loadAsync(encodeURI(url));
  };
  const found = [];
  for (const name of names)
    for (const line of await differences(await load(`/corpus/${kind}.plain/${name}`), await load(`/corpus/${kind}/${name}`)))
      found.push(`${name}: ${line}`);
  pool.dispose();
  draco.dispose();
  return found;
}

for (const kind of ['patches', 'draco'])
  page_test(`the corpus in ${kind}, in Chromium`, {
    skip, script: compare_corpus, argument: { kind, names: corpus[kind] }, errors: [],
    files: { '/': page, '/corpus/': { folder }, '/compare_scenes.mjs': { folder: fileURLToPath(new URL('compare_scenes.mjs', import.meta.url)) } },
  }, async ({ result }) => assert.deepEqual(await result, []));
