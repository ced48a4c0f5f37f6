// Babylon.js' glTF loader with psplit/babylon, in Chromium. gltf-psplit decodes the same arrays.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after } from 'node:test';
import { page_test } from './browser.mjs';
import { compressed_primitives, corpus_folder, gltf_psplit, read_asset, root, with_asset } from './load.mjs';
import { endless, part_of_file, serve_ranges, serve_slowly, wait_ms } from './slow_server.mjs';

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const folder = mkdtempSync(path.join(tmpdir(), 'psplit-babylon-'));
after(() => rmSync(folder, { recursive: true }));

const imports = { '@babylonjs/core/': '/modules/@babylonjs/core/', '@babylonjs/loaders/': '/modules/@babylonjs/loaders/' };
const page = `<!doctype html><canvas width="200" height="200"></canvas>
  <script type="importmap">${JSON.stringify({ imports })}</script><script type="module" src="/main.js"></script>`;

// Sets facts(url) in the page. It returns Babylon.js' data of an asset's meshes, or the error's message.
async function prepare() {
  const { NullEngine } = await import('@babylonjs/core/Engines/nullEngine.js');
  const { Scene } = await import('@babylonjs/core/scene.js');
  const { LoadAssetContainerAsync, SceneLoader } = await import('@babylonjs/core/Loading/sceneLoader.js');
  const { registerGLTFExtension } = await import('@babylonjs/loaders/glTF/2.0/index.js');
  const { createPool } = await import('/psplit/index.js'), { loadStreaming, registerPsplit } = await import('/psplit/babylon.js');
  const { digest } = await import('/page.js');
  globalThis.pool = createPool({ workers: 2 });
  registerPsplit(registerGLTFExtension, { pool });
  Object.assign(globalThis, { registerGLTFExtension, registerPsplit, SceneLoader });
  const engine = new NullEngine();

  const values = async (numbers) => numbers && [numbers.length, await digest(Float64Array.from(numbers))];
  const buffer_facts = async (buffer, points) => ({ type: buffer.type, size: buffer.getSize(), normalized: buffer.normalized,
    values: await values(buffer.getFloatData(points)) });
  const mesh_facts = async (item) => {
    const mesh = item.sourceMesh ?? item;  // of an instance
    const kinds = mesh.getVerticesDataKinds().sort(), targets = mesh.morphTargetManager;
    const { minimum, maximum } = mesh.getBoundingInfo(), points = mesh.getTotalVertices();
    return { name: item.name, points, indices: await values(mesh.getIndices()),
      attributes: await Promise.all(kinds.map(async (kind) => [kind, await buffer_facts(mesh.getVertexBuffer(kind), points)])),
      box: [minimum.asArray(), maximum.asArray()], alpha: mesh.hasVertexAlpha, influencers: mesh.numBoneInfluencers,
      targets: await Promise.all(Array.from({ length: targets?.numTargets ?? 0 }, async (_, i) =>
        Promise.all(['Positions', 'Normals', 'Tangents', 'UVs'].map((of) => values(targets.getTarget(i)[`get${of}`]()))))) };
  };
  globalThis.streamed = (url, scene, options) => loadStreaming(LoadAssetContainerAsync, url, scene, options);
  // The meshes of load(scene, parts). When it resolves, `go` is asked for, if there is one.
  globalThis.facts_of = async (load, go) => {
    const scene = new Scene(engine), parts = [];
    try {
      const { meshes, psplit: { whole } } = await load(scene, parts), first_parts = parts.length;
      const drawn = () => meshes.reduce((sum, mesh) => sum + (mesh.getIndices() ?? []).filter((point) => point > 0).length, 0);
      const drawn_first = drawn();
      if (go !== undefined) await (await fetch(go)).text();
      await whole;
      return { meshes: await Promise.all(meshes.map(mesh_facts)), parts, first_parts, drawn: [drawn_first, drawn()] };
    } finally {
      scene.dispose();
    }
  };
  globalThis.facts = async (url) => {
    const scene = new Scene(engine);
    try {
      const { meshes } = await LoadAssetContainerAsync(url, scene);
      return await Promise.all(meshes.map(mesh_facts));
    } catch ({ message }) {
      return message;
    } finally {
      scene.dispose();
    }
  };
}

// The assets are samples, a large mesh, and assets of the corpus with normals, texture coordinates, colours, skins, morph targets
// and quantized attributes. gltf-psplit encodes them, and decodes them for the comparison.
const assets = ['patches.glb', 'residue.glb', 'condensed.glb', 'condensed-borders.glb', 'seams.glb', 'coarse.glb', 'targets.glb', 'condensed-targets.glb']
  .map((name) => ({ name, encoded: path.join(samples, name) }));
if (gltf_psplit !== null) {
  const mesh = path.join(folder, 'mesh.glb'), encoded = path.join(folder, 'large.glb');
  execFileSync(gltf_psplit, ['generate', mesh, '--shape', 'terrain', '--faces', '60000', '--seed', '1', '--normals', '-q']);
  execFileSync(gltf_psplit, ['encode', mesh, encoded, '--patch-faces', '1500', '-q']);
  assets.push({ name: 'large.glb', encoded });
}
const large = assets.length - 1;
if (corpus_folder !== null && gltf_psplit !== null) {
  for (const file of ['draco/Duck.glb', 'draco/CesiumMan.glb', 'gt/ShapeCollection.glb', 'gt/BoxVertexColors.glb',
    'bjs/riggedMesh.glb', 'bjs/greySnapper_vertColor.glb', 'bjs/morphLoader.glb', 'derived/AnimatedMorphCube.quant.glb',
    'derived/scallop.quant.glb', '3dt/tree-lime-2-0.glb', 'mor/Horse.glb', 'mor/rpm_avatar.glb']) {
    const name = path.basename(file), encoded = path.join(folder, name);
    execFileSync(gltf_psplit,
      ['encode', path.join(corpus_folder, 'gltf', file), encoded, '--always-patches', '--patch-faces', '500', '-q']);
    assets.push({ name, encoded });
  }
}

const files = { '/': page };
if (gltf_psplit !== null)
  for (const [i, { encoded }] of assets.entries()) {
    const plain = path.join(folder, `${i}.glb`);
    execFileSync(gltf_psplit, ['decode', encoded, plain, '-q']);
    files[`/${i}/encoded.glb`] = readFileSync(encoded);
    files[`/${i}/plain.glb`] = readFileSync(plain);
  }

// Several workers decode large meshes, into shared memory if the page is isolated.
const isolation = { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' };

const no_tool = gltf_psplit === null && 'there is no gltf-psplit';
page_test('meshes are those of the asset that gltf-psplit decodes', { skip: no_tool, files, headers: isolation, script: prepare },
async ({ result, page }) => {
  await result;
  let attributes = 0;
  for (const [i, { name }] of assets.entries()) {
    const [encoded, plain] = await page.evaluate((i) => Promise.all([facts(`/${i}/encoded.glb`), facts(`/${i}/plain.glb`)]), i);
    assert.ok(Array.isArray(encoded), `${name}: ${encoded}`);
    assert.deepEqual(encoded, plain, name);
    attributes += encoded.flatMap(({ attributes }) => attributes).length;
  }
  assert.ok(attributes > assets.length);
});

// Assets of the corpus with Draco streams. psplit/draco takes the place of draco3d.
const draco_assets = corpus_folder === null ? []
  : ['draco/Box_Draco.glb', 'derived/CesiumMan.draco-seq.glb', 'derived/marbleTower.draco-eb.glb'];
page_test('KHR_draco_mesh_compression by psplit/babylon, and by Babylon.js on psplit/draco and on draco3d', {
  skip: corpus_folder === null && 'there is no corpus', script: prepare, files: { '/': page,
    ...Object.fromEntries(draco_assets.map((file, i) => [`/${i}.glb`, { folder: path.join(corpus_folder, 'gltf', file) }])) },
}, async ({ result, page, site }) => {
  await result;
  const facts_of_all = (draco) => page.evaluate((draco, count) => {
    registerPsplit(registerGLTFExtension, { pool, draco });
    return Promise.all(Array.from({ length: count }, (_, i) => facts(`/${i}.glb`)));
  }, draco, draco_assets.length);
  const without_babylon = await facts_of_all(true);
  assert.ok(!site.requests.some((url) => url.endsWith('/draco_decoder.wasm')) && without_babylon.every(Array.isArray), JSON.stringify(without_babylon));
  await page.evaluate(() => registerPsplit(registerGLTFExtension, { pool, draco: false }));
  const facts_with = (folder) => page.evaluate(async (folder, count) => {
    const { DracoDecoder } = await import('@babylonjs/core/Meshes/Compression/dracoDecoder.js');
    DracoDecoder.ResetDefault();
    DracoDecoder.DefaultConfiguration =
      { wasmUrl: `${folder}draco_wasm_wrapper.js`, wasmBinaryUrl: `${folder}draco_decoder.wasm` };
    return Promise.all(Array.from({ length: count }, (_, i) => facts(`/${i}.glb`)));
  }, folder, draco_assets.length);
  const [ours, theirs] = [await facts_with('/psplit/draco/'), await facts_with('/modules/three/examples/jsm/libs/draco/gltf/')];
  assert.ok(ours.every(Array.isArray), JSON.stringify(ours));
  assert.deepEqual(ours, theirs);
  assert.deepEqual(without_babylon, theirs);
  assert.ok(site.requests.includes('/psplit/draco/draco_decoder.wasm'));
});

// The sample with a fallback has its container in a file of its own.
const fallback = readFileSync(path.join(samples, 'fallback.gltf'), 'utf8');
const of_fallback = (name) => readFileSync(path.join(samples, JSON.parse(fallback).buffers[name === 'container' ? 0 : 1].uri));
function asset(at, change_container, change_json = () => {}) {
  const json = JSON.parse(fallback), container = of_fallback('container');
  change_container(container);
  change_json(json);
  return { [`/${at}/a.gltf`]: JSON.stringify(json), [`/${at}/${json.buffers[0].uri}`]: container,
    [`/${at}/${json.buffers[1].uri}`]: of_fallback('data') };
}
const newer_version = (container) => { container[4] = 99; };
const broken_patch = (container) => container.fill(0xff, 1800);
const without_fallback = (json) => json.accessors.forEach((accessor) => delete accessor.bufferView);
const only_fallback = (json) => {
  delete json.extensionsUsed;
  delete json.meshes[0].primitives[0].extensions;
};

page_test('fallback, errors, and the end of a load', { script: prepare, files: { '/': page,
  ...asset('sample', () => {}), ...asset('plain', () => {}, only_fallback), ...asset('newer', newer_version),
  ...asset('broken', broken_patch), ...asset('newer_only', newer_version, without_fallback),
  ...asset('wrong_count', () => {}, ({ accessors }) => { accessors[1].count = 7; }),
  ...asset('wrong_mode', () => {}, ({ meshes }) => { meshes[0].primitives[0].mode = 5; }),
  ...asset('two', () => {}, ({ meshes, nodes, scenes }) => {
    meshes.push({ primitives: [meshes[0].primitives[0]] });
    nodes.push({ mesh: 1 });
    scenes[0].nodes.push(1);
  }) } }, async ({ result, page }) => {
  await result;
  const facts = (name) => page.evaluate((name) => globalThis.facts(`/${name}/a.gltf`), name);
  const plain = await facts('plain');
  assert.equal(plain.length, 2);
  assert.deepEqual(await facts('sample'), plain);
  assert.deepEqual(await facts('newer'), plain);
  const [root, first, second] = await facts('two');
  assert.deepEqual([root, first], plain);
  assert.deepEqual(second, { ...first, name: 'node1' });
  const place = '/meshes/0/primitives/0/extensions/PSPLIT_mesh_draco_patches: ';
  for (const [name, message] of [['broken', 'patch \\d+: Draco stream: '], ['newer_only', 'container: version 99'],
    ['wrong_count', 'the accessor of NORMAL has 7 points, but the patches have 179'],
    ['wrong_mode', 'patches are triangle lists']])
    assert.match(await facts(name), new RegExp(place + message), name);
  // A load that is disposed ends its jobs.
  const jobs = await page.evaluate(async () => {
    const events = [];
    await new Promise((resolve) => {
      let plugin;
      registerPsplit(registerGLTFExtension, { pool: { decodeContainer: (bytes, { signal }) => new Promise((_, reject) => {
        signal.addEventListener('abort', () => {
          events.push('aborted');
          reject(new Error('aborted'));
          resolve();
        });
        plugin.dispose();
      }) } });
      SceneLoader.OnPluginActivatedObservable.addOnce((activated) => { plugin = activated; });
      globalThis.facts('/sample/a.gltf').then(() => events.push('settled'));
    });
    return events;
  });
  assert.deepEqual(jobs, ['aborted']);
  // Without an option, a pool is made.
  await page.evaluate(() => registerPsplit(registerGLTFExtension));
  assert.deepEqual(await facts('sample'), plain);
});

page_test('loadStreaming decodes patches while their bytes arrive', { skip: no_tool, files, script: prepare,
  errors: [/[ab]\/large.glb: net::ERR_ABORTED/, /status of 404/, /none.glb: net::ERR_ABORTED/] }, async ({ result, page }) => {
  await result;
  const bytes = readFileSync(assets[large].encoded);
  let go;  // sends the second half of the bytes
  const until_gone = new Promise((resolve) => (go = resolve));
  async function* halves() {
    yield bytes.slice(0, bytes.length / 2);
    await until_gone;
    yield bytes.slice(bytes.length / 2);
  }
  const { origin, open } = await serve_slowly({ '/a/large.glb': halves, '/b/large.glb': () => endless(bytes.slice(0, bytes.length / 20)),
    '/go': () => (go(), []) });
  // The meshes are there with their first patches, before the other bytes are sent.
  const { meshes, parts, first_parts, drawn } = await page.evaluate((origin) => facts_of((scene, parts) => streamed(`${origin}/a/large.glb`, scene, {
    onPart: ({ indices }) => parts.push(indices.length) }), `${origin}/go`), origin);
  assert.deepEqual(meshes, await page.evaluate((i) => globalThis.facts(`/${i}/plain.glb`), large));
  assert.equal(parts.reduce((sum, count) => sum + count, 0), meshes.reduce((sum, { indices }) => sum + (indices?.[0] ?? 0), 0));
  assert.ok(first_parts > 0 && first_parts < parts.length, `${first_parts} of ${parts.length}`);
  assert.ok(drawn[0] > 0 && drawn[0] < 0.9 * drawn[1], `${drawn}`);
  const whole = await page.evaluate((url) => facts_of((scene) => streamed(url, scene, { patchByPatch: false })), `${origin}/a/large.glb`);
  assert.deepEqual([whole.meshes, whole.drawn[0]], [meshes, drawn[1]]);

  const code = await page.evaluate(async (url) => {
    const stop = new AbortController();
    setTimeout(() => stop.abort(), 300);
    return (await facts_of((scene) => streamed(url, scene, { signal: stop.signal })).catch((error) => error)).code;
  }, `${origin}/b/large.glb`);
  assert.equal(code, 'aborted');
  for (let left = 200; left > 0 && open.has('/b/large.glb'); --left) await wait_ms(5);
  assert.ok(!open.has('/b/large.glb'));
  assert.equal((await page.evaluate((url) => facts_of((scene) => streamed(url, scene)).catch((error) => error.code), `${origin}/none.glb`)), 'failed');
});

page_test('loadStreaming of chosen patches', { skip: no_tool, script: prepare, files }, async ({ result, page }) => {
  await result;
  const encoded = (...options) => with_asset(124000, ['--patch-faces', '500', ...options], (file) => readFileSync(file));
  const made = { '/a.glb': encoded(), '/b.glb': encoded('--condense', '--profile', 'size') };
  const { origin, sent } = await serve_ranges((name, range) => {
    const { headers, ...answer } = part_of_file(made[name], range);
    return { ...answer, headers: { ...headers, 'Access-Control-Allow-Origin': '*', 'Access-Control-Expose-Headers': 'Content-Range, ETag' } };
  });
  for (const name of Object.keys(made))
    for (const patchByPatch of [true, false])
      for (const is_all of [false, true]) {  // all patches alone have more points than 16 bits can tell apart
        const before = sent();
        const same = await page.evaluate(async (url, patchByPatch, is_all) => {
          const choose = ({ patchCount }) => (is_all ? Array.from({ length: patchCount }, (_, i) => i) : [patchCount - 1, 3, 2, 0]);
          const { NullEngine } = await import('@babylonjs/core/Engines/nullEngine.js'), { Scene } = await import('@babylonjs/core/scene.js');
          const scene = new Scene(new NullEngine()), { meshes, psplit } = await streamed(url, scene, { patchByPatch, choose });
          await psplit.whole;
          const { primitives: [{ indices, attributes, pointCount }] } = await pool.decodeUrl(url, { choose });
          const mesh = meshes.find((of) => of.getTotalVertices() > 0), is_equal = (a, b) => a.length === b.length && a.every((value, i) => value === b[i]);
          return [mesh.getTotalVertices() === pointCount, pointCount > 65535 === is_all, is_equal(mesh.getIndices(), indices),
            ...['position', 'normal', 'uv'].map((kind, i) => is_equal(mesh.getVertexBuffer(kind).getFloatData(pointCount), attributes[i].array))];
        }, origin + name, patchByPatch, is_all);
        assert.deepEqual(same, same.map(() => true), name);
        assert.ok(is_all || sent() - before < made[name].length);
      }
});

// A sample whose morph targets are all in patches.
const morphing = read_asset(path.join(samples, 'targets.glb')), [{ primitives: [morphing_primitive] }] = morphing.json.meshes;
morphing_primitive.targets.pop();
Object.values(morphing_primitive.extensions.PSPLIT_mesh_draco_patches.targets).forEach((ids) => ids.pop());
morphing.json.buffers[0].uri = `data:application/octet-stream;base64,${Buffer.from(morphing.view_bytes(0)).toString('base64')}`;
page_test('chosen patches with morph targets', { script: prepare, files: { '/': page, '/a.gltf': JSON.stringify(morphing.json) } }, async ({ result, page }) => {
  await result;
  const same = await page.evaluate(async () => {
    const { NullEngine } = await import('@babylonjs/core/Engines/nullEngine.js'), { Scene } = await import('@babylonjs/core/scene.js');
    const choose = () => [2, 0], { primitives: [{ indices, attributes, pointCount, patchCount }] } = await pool.decodeUrl('/a.gltf', { choose });
    const { meshes, psplit } = await streamed('/a.gltf', new Scene(new NullEngine()), { choose });
    await psplit.whole;
    const mesh = meshes.find((of) => of.getTotalVertices() > 0), data = (name) => attributes.find((attribute) => attribute.name === name).array;
    const target = mesh.morphTargetManager.getTarget(1), positions = data('POSITION').map((value, i) => value + data('targets/1/POSITION')[i]);
    const is_equal = (a, b) => a.length === b.length && a.every((value, i) => value === b[i]);
    return [patchCount === 2, mesh.getTotalVertices() === pointCount, is_equal(mesh.getIndices(), indices), is_equal(target.getPositions(), positions)];
  });
  assert.deepEqual(same, [true, true, true, true]);
});

page_test('a mesh that grows on screen, and one that fails on the way', { skip: no_tool, headers: isolation, files, script: prepare,
  errors: [/\.glb: net::ERR_ABORTED/] },
  async ({ result, page }) => {
    await result;
    const bytes = readFileSync(assets[large].encoded), broken = Uint8Array.from(bytes);
    broken.fill(0xff, broken.length - 300);
    let go;  // sends the second half of the bytes
    const halves = (of) => async function* () {
      yield of.slice(0, of.length / 2);
      await new Promise((resolve) => (go = resolve));
      yield of.slice(of.length / 2);
    };
    const { origin } = await serve_slowly({ '/a.glb': halves(bytes), '/broken.glb': halves(broken), '/aborted.glb': halves(bytes),
      '/go': () => (go(), []) });
    // Frames with the first patches and after `whole`, as pixels that are not the background, and the pixels' digest.
    const frames = (url, is_aborted = false) => page.evaluate(async (url, is_aborted) => {
      const { Engine } = await import('@babylonjs/core/Engines/engine.js'), { Scene } = await import('@babylonjs/core/scene.js');
      const { AppendSceneAsync } = await import('@babylonjs/core/Loading/sceneLoader.js'), { digest } = await import('/page.js');
      await Promise.all([import('@babylonjs/core/Helpers/sceneHelpers.js'), import('@babylonjs/core/Loading/loadingScreen.js')]);
      const { loadStreaming } = await import('/psplit/babylon.js');
      const engine = new Engine(document.querySelector('canvas')), scene = new Scene(engine), stop = new AbortController();
      const { psplit } = url.endsWith('/plain.glb') ? (await AppendSceneAsync(url, scene), { psplit: { whole: null } })
        : await loadStreaming(AppendSceneAsync, url, scene, { signal: stop.signal });
      scene.createDefaultCameraOrLight(true);
      await scene.whenReadyAsync();
      const draw = async () => {
        scene.render();
        const { buffer } = await engine.readPixels(0, 0, 200, 200), pixels = new Uint32Array(buffer);
        return { drawn: pixels.filter((pixel) => pixel !== pixels[0]).length, pixels: await digest(pixels) };
      };
      const first = await draw();
      if (is_aborted) stop.abort();
      else if (psplit.whole !== null) await (await fetch(new URL('/go', url))).text();
      const code = await psplit.whole?.catch((error) => error.code), last = await draw();
      engine.dispose();
      return { first, last, code };
    }, url, is_aborted);
    const grown = await frames(`${origin}/a.glb`), plain = await frames(`/${large}/plain.glb`);
    assert.ok(grown.first.drawn > 100 && grown.first.drawn < grown.last.drawn, JSON.stringify(grown));
    assert.deepEqual([grown.last, grown.code], [plain.last, undefined]);
    for (const [name, is_aborted, expected] of [['broken', false, 'invalid-input'], ['aborted', true, 'aborted']]) {
      const { first, last, code } = await frames(`${origin}/${name}.glb`, is_aborted);
      assert.ok(first.drawn > 100);
      assert.deepEqual([last.drawn, code], [0, expected]);
    }
  });

page_test('a frame', { skip: no_tool, headers: isolation, files, script: prepare },
  async ({ result, page }) => {
    await result;
    // Draws a frame, and returns its pixels' digest and number of colours.
    const draw = (url) => page.evaluate(async (url) => {
      const { Engine } = await import('@babylonjs/core/Engines/engine.js'), { Scene } = await import('@babylonjs/core/scene.js');
      const { AppendSceneAsync } = await import('@babylonjs/core/Loading/sceneLoader.js');
      await Promise.all([import('@babylonjs/core/Helpers/sceneHelpers.js'), import('@babylonjs/core/Loading/loadingScreen.js')]);
      const engine = new Engine(document.querySelector('canvas')), scene = new Scene(engine);
      await AppendSceneAsync(url, scene);
      scene.createDefaultCameraOrLight(true);
      await scene.whenReadyAsync();
      scene.render();
      const { buffer } = await engine.readPixels(0, 0, 200, 200), pixels = new Uint32Array(buffer);
      engine.dispose();
      const { digest } = await import('/page.js');
      return { colours: new Set(pixels).size, pixels: await digest(pixels) };
    }, url);
    const frame = await draw(`/${large}/encoded.glb`);
    assert.ok(frame.colours > 50, `${frame.colours} colours`);
    assert.deepEqual(await draw(`/${large}/plain.glb`), frame);
  });
