// loadStreaming in three's GLTFLoader: meshes grow while their bytes arrive from a slow server.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after } from 'node:test';
import { geometries_of, geometry_differences, values_of } from './compare_scenes.mjs';
import { fallback_files, gltf_psplit, psplit, root, with_asset } from './load.mjs';
import { in_chunks, part_of_file, serve_ranges, serve_slowly, wait_ms } from './slow_server.mjs';
import { buffer_of, loadStreaming, make_loader, THREE } from './three_loaders.mjs';

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const pool = psplit.createPool({ workers: 2 });
after(() => pool.dispose());
const needs_tool = { skip: gltf_psplit === null && 'there is no gltf-psplit' };
const large = gltf_psplit === null ? null : with_asset(60000, ['--patch-faces', '2000'], (file) => readFileSync(file));
const kChunks = 20, kPause = 40;
const chunks_of_large = () => in_chunks(large, () => Math.ceil(large.length / kChunks), kPause);

const geometry_of = async (gltf) => (await geometries_of(gltf)).get('mesh 0, primitive 0');
const drawn = ({ index: { array } }) => array.reduce((sum, point, i) => sum + (i % 3 === 0 && (point | array[i + 1] | array[i + 2]) !== 0 ? 1 : 0), 0);

test('the samples are those that the plugin loads', async () => {
  const names = ['patches.glb', 'condensed.glb', 'seams.glb', 'residue.glb', 'coarse.glb', 'targets.glb', 'fallback.gltf'];
  const files = Object.fromEntries([...names, ...fallback_files]
    .map((name) => [`/${name}`, () => in_chunks(readFileSync(path.join(samples, name)), () => 5000, 1)]));
  const { origin } = await serve_slowly(files);
  for (const name of names)
    for (const patchByPatch of [true, false]) {
      const gltf = await loadStreaming(make_loader(), `${origin}/${name}`, { pool, patchByPatch });
      await gltf.psplit.whole;
      const usual = await make_loader({ plugin: { pool } }).loadAsync(`${origin}/${name}`);
      assert.deepEqual(geometry_differences(await geometry_of(usual), await geometry_of(gltf)), [], name);
    }
});

test('the first triangles come before half of the bytes', needs_tool, async () => {
  const { origin, done } = await serve_slowly({ '/models/large.glb': chunks_of_large });
  const loader = make_loader().setPath(`${origin}/models/`), progress = [];
  const gltf = await loadStreaming(loader, 'large.glb', { pool, onProgress: (count, total) => progress.push([count, total]) });
  const geometry = await geometry_of(gltf), first = drawn(geometry), total = geometry.index.count / 3;
  assert.ok(!done.has('/models/large.glb'));
  assert.ok(first > 0 && first < total / 2, `${first} of ${total}`);
  await gltf.psplit.whole;
  assert.equal(drawn(geometry), total);
  assert.ok(progress.length > 5);
  const usual = await make_loader({ plugin: { pool } }).parseAsync(buffer_of(large), '');
  assert.deepEqual(geometry_differences(await geometry_of(usual), geometry), []);
  assert.equal(loader.pluginCallbacks.length, make_loader().pluginCallbacks.length);  // the loader is as before
});

test('an abort ends the load at once, before and after the first patches', needs_tool, async () => {
  const { origin, open, done } = await serve_slowly({ '/a.glb': chunks_of_large, '/b.glb': chunks_of_large, '/c.glb': chunks_of_large });
  const aborted = { name: 'PsplitError', code: 'aborted' }, ended = async (name) => {
    for (let left = 100; left > 0 && open.has(name); --left) await wait_ms(2);
    assert.ok(!open.has(name));
  };
  const early = new AbortController(), manager = new THREE.LoadingManager();
  setTimeout(() => early.abort(), 2 * kPause);
  await assert.rejects(loadStreaming(make_loader(), `${origin}/a.glb`, { pool, signal: early.signal, patchByPatch: false }), aborted);
  assert.ok(!done.has('/a.glb'));
  await ended('/a.glb');

  const late = new AbortController(), gltf = await loadStreaming(make_loader(), `${origin}/b.glb`, { pool, signal: late.signal });
  const geometry = await geometry_of(gltf);
  assert.ok(drawn(geometry) > 0);
  late.abort();
  await assert.rejects(gltf.psplit.whole, aborted);
  await ended('/b.glb');
  assert.equal(drawn(geometry), 0);

  setTimeout(() => manager.abort(), 2 * kPause);
  await assert.rejects(loadStreaming(make_loader({ manager }), `${origin}/c.glb`, { pool, patchByPatch: false }), aborted);
  await ended('/c.glb');
  await assert.rejects(loadStreaming(make_loader(), `${origin}/c.glb`, { pool, signal: AbortSignal.abort() }), aborted);
});

test('errors, and the loading manager', async () => {
  const glb = readFileSync(path.join(samples, 'patches.glb')), broken = Uint8Array.from(glb);
  broken.fill(0xff, glb.length - 60);
  const { origin } = await serve_slowly({ '/broken.glb': () => [broken], '/cut.glb': () => [glb.subarray(0, -9)], '/text': () => ['text'], '/old.gltf': () => ['{"asset":{"version":"1.0"}}'] });
  const load = async (name) => {
    const manager = new THREE.LoadingManager(), ended = new Promise((resolve) => (manager.onLoad = resolve)), failed = [];
    manager.onError = (item) => failed.push(item);
    try {
      const gltf = await loadStreaming(make_loader({ manager }), `${origin}/${name}`, { pool });
      await gltf.psplit.whole;
    } finally {
      await ended;
      assert.ok(failed.length > 0);
    }
  };
  await assert.rejects(load('missing.glb'), { name: 'PsplitError', code: 'failed', message: /missing.glb: HTTP status 404/ });
  await assert.rejects(load('text'), { name: 'PsplitError', code: 'invalid-input' });
  await assert.rejects(load('old.gltf'), /Unsupported asset/);
  await assert.rejects(load('broken.glb'), { name: 'PsplitError', code: 'invalid-input', mesh: 0, primitive: 0, message: /broken.glb: mesh 0/ });
  await assert.rejects(load('cut.glb'), { name: 'PsplitError', code: 'invalid-input', mesh: 0 });
});

test('chosen patches', needs_tool, async () => {
  const options = ['--patch-faces', '500'];
  const files = { '/a.glb': large, '/condensed.glb': with_asset(60000, [...options, '--condense', '--profile', 'size'], (file) => readFileSync(file)),
    // All patches alone have more points than 16 bits can tell apart, and the mesh has not.
    '/wide.glb': with_asset(124000, options, (file) => readFileSync(file)) };
  const { origin, sent } = await serve_ranges((name, range) => part_of_file(files[name], range));
  const some = ({ patchCount }) => [patchCount - 1, 3, 2, 0], all = ({ patchCount }) => Array.from({ length: patchCount }, (_, i) => i);
  for (const [name, choose] of [['a', some], ['condensed', some], ['wide', all], ['wide', some], ['a', () => []]])
    for (const patchByPatch of [true, false]) {
      const url = `${origin}/${name}.glb`, before = sent(), told = [], parts = [];
      const gltf = await loadStreaming(make_loader(), url, { pool, patchByPatch, onPart: (part) => parts.push(part.indices.length),
        choose: ({ mesh, primitive, ...of }) => { told.push([mesh, primitive]); return choose(of); } });
      await gltf.psplit.whole;
      assert.ok(choose === all || sent() - before < 0.7 * files[`/${name}.glb`].length, `${name}: ${sent() - before}`);
      const { primitives: [expected] } = await pool.decodeUrl(url, { choose }), geometry = await geometry_of(gltf);
      assert.deepEqual(Uint32Array.from(geometry.index.array), expected.indices);
      for (const [i, key] of ['position', 'normal', 'uv'].entries()) {
        assert.equal(geometry.attributes[key].count, expected.pointCount);
        assert.deepEqual(Float32Array.from(values_of(geometry.attributes[key])), Float32Array.from(expected.attributes[i].array), `${name}: ${key}`);
      }
      assert.equal(geometry.index.array.BYTES_PER_ELEMENT, expected.pointCount > 65535 ? 4 : 2);
      let facts = null;
      gltf.scene.traverse((object) => { facts ??= object.isMesh ? gltf.psplit.patchesOf(object) : null; });
      assert.deepEqual([facts.chosen, facts.faceCount, facts.firstFaces], [expected.chosen, expected.faceCount, expected.firstFaces]);
      assert.deepEqual(told, [[0, 0]]);
      if (patchByPatch) assert.equal(parts.reduce((sum, count) => sum + count, 0), expected.indices.length);
    }
  const { primitives: [wide] } = await pool.decodeUrl(`${origin}/wide.glb`, { choose: all });
  assert.ok(wide.pointCount > 65535 && (await pool.decodeUrl(`${origin}/wide.glb`)).primitives[0].pointCount < 65535);
});

test('primitives with data that is not in patches are whole', async () => {
  const gltf = JSON.parse(readFileSync(path.join(samples, 'fallback.gltf'), 'utf8')), [{ primitives: [primitive] }] = gltf.meshes;
  const files = Object.fromEntries(gltf.buffers.map(({ uri }) => [`/${uri}`, readFileSync(path.join(samples, uri))]));
  const load = async (json, facts_of = ({ index }) => index.count) => {
    const { origin } = await serve_ranges((name, range) => part_of_file(files[name] ?? Buffer.from(JSON.stringify(json)), range));
    const gltf_ = await loadStreaming(make_loader(), `${origin}/a.gltf`, { pool, choose: () => [0] });
    await gltf_.psplit.whole;
    return facts_of(await geometry_of(gltf_));
  };
  const whole = gltf.accessors[primitive.indices].count, targets = [{ POSITION: primitive.attributes.POSITION }];
  assert.ok(await load(gltf) < whole);
  // Patches may be left out if all targets are in the patches.
  const stored = { ...primitive.extensions.PSPLIT_mesh_draco_patches, targets: { POSITION: [0] } };
  const morphing = await load({ ...gltf, meshes: [{ primitives: [{ ...primitive, targets, extensions: { PSPLIT_mesh_draco_patches: stored } }] }] }, (geometry) => {
    const { position } = geometry.attributes, { position: [target] } = geometry.morphAttributes;
    assert.deepEqual(target.array, position.array);
    return geometry.index.count;
  });
  assert.ok(morphing < whole);
  assert.equal(await load({ ...gltf, meshes: [{ primitives: [{ ...primitive, targets }] }] }), whole);
  assert.equal(await load({ ...gltf, meshes: [{ primitives: [{ ...primitive, attributes: { ...primitive.attributes, _OTHER: primitive.attributes.POSITION } }] }] }), whole);
  // Equal primitives share the chosen patches.
  assert.ok(await load({ ...gltf, meshes: [{ primitives: [primitive] }, { primitives: [primitive] }] }) < whole);
});
