// The code of bindings/web/README.md runs: each block alone, in Node.js or in a page of Chromium.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { page_test, start_site } from './browser.mjs';
import { compressed_primitives, link_package, modules_folder, psplit, readme_blocks, root } from './load.mjs';
import { draco_glb, streams, with_draco_mesh } from './stock_draco.mjs';

link_package();
const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb');
const [{ bytes: container }] = compressed_primitives(sample, 'PSPLIT_mesh_draco_patches'), [[, stream]] = [...streams()];

const { decodeDraco } = psplit, blocks = readme_blocks();

// In Node.js, as a module of a project that has the package.
const folder = path.join(root, 'build/web/readme');
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
async function run(code, names, globals) {
  const file = path.join(folder, `${names.join('-')}.mjs`), before = process.cwd();
  Object.assign(globalThis, globals);
  writeFileSync(file, `${code}\nexport { ${names} };`);
  copyFileSync(sample, path.join(folder, 'model.glb'));
  process.chdir(folder);
  try {
    return await import(pathToFileURL(file));
  } finally {
    process.chdir(before);
  }
}
const tested = new Set();
function block(heading, i = 0) {
  tested.add(`${heading} ${i}`);
  return blocks[heading][i];
}

test('glTF-Transform', async () => {
  const points_of = (document) => document.getRoot().listMeshes()[0].listPrimitives()[0].getAttribute('POSITION').getCount();
  const { document, io } = await run(block('glTF-Transform'), ['document', 'io'], {});
  const { document: ahead } = await run(block('glTF-Transform', 1), ['document'], {});
  assert.equal(points_of(document), points_of(ahead));
  assert.equal(points_of(await io.read(path.join(folder, 'out.glb'))), points_of(document));
});
test('the command of glTF-Transform', { timeout: 60000 }, () => {
  writeFileSync(path.join(folder, 'psplit.config.mjs'), block('glTF-Transform', 2));
  copyFileSync(sample, path.join(folder, 'model.glb'));
  const command = path.join(modules_folder, 'node_modules/.bin/gltf-transform');
  const inspected = (...options) => spawnSync(command, ['inspect', 'model.glb', ...options], { cwd: folder, encoding: 'utf8' });
  const { stdout, stderr } = inspected('--config', 'psplit.config.mjs');
  assert.match(stdout, /PSPLIT_mesh_draco_patches/);
  assert.match(stdout, /TRIANGLES.*1,222/, stderr);
  const without = inspected();
  assert.match(without.stdout + without.stderr, /Missing required extension/);
});
test('encoding', async () => {
  const { decodeGlb } = await import(pathToFileURL(path.join(root, 'build/web/psplit/asset.js')));
  const plain = path.join(folder, 'plain.glb');
  const { io, document: patched } = await run(block('glTF-Transform'), ['io', 'document'], {});
  // The asset without its containers.
  for (const extension of patched.getRoot().listExtensionsUsed()) extension.dispose();
  await io.write(plain, patched);
  const { document } = await run(block('Encoding'), ['document', 'psplit'], {});
  const { primitives: [{ coding, indices }] } = await decodeGlb(readFileSync(path.join(folder, 'patches.glb')));
  assert.deepEqual([coding, indices.length / 3], ['patches', document.getRoot().listMeshes()[0].listPrimitives()[0].getIndices().getCount() / 3]);
  const in_node = block('Encoding', 1).replace("'/plain.glb'", JSON.stringify(pathToFileURL(plain).href));
  const { encoded: { container: made, patchCount, positionError } } = await run(in_node, ['encoded'], {});
  assert.ok(made.length > 1000 && patchCount === 1 && positionError < 0.01, `${made.length} ${patchCount} ${positionError}`);
});
test('the encoder in place of draco3d', async () => {
  const { io, KHRDracoMeshCompression } = await run(block('Encoding, in place of draco3d'), ['io', 'KHRDracoMeshCompression'], {});
  const { document } = await run(block('glTF-Transform'), ['document'], {});
  document.createExtension(KHRDracoMeshCompression).setRequired(true);
  for (const extension of document.getRoot().listExtensionsUsed()) if (extension.extensionName === 'PSPLIT_mesh_draco_patches') extension.dispose();
  const { extensionsUsed } = await io.writeJSON(document).then(({ json }) => json);
  assert.deepEqual(extensionsUsed, ['KHR_draco_mesh_compression']);
});
test('streams and containers', async () => {
  const { mesh, converted, whole } = await run(block('Streams and containers'), ['mesh', 'converted', 'whole'], { bytes: stream, container });
  assert.deepEqual(converted.attributes[0].array, mesh.attributes[0].array);
  assert.equal(whole.attributes[0].array.length, 3 * whole.pointCount);
});
test('workers', async () => {
  const { log } = console, lines = [];
  console.log = (line) => lines.push(line);
  try {
    const { meshes, whole } = await run(block('Workers'), ['meshes', 'whole'], { streams: [stream, stream], container });
    assert.deepEqual(meshes[0], meshes[1]);
    assert.equal(lines.at(-1), `${whole.patchCount} of ${whole.patchCount} patches`);
  } finally {
    console.log = log;
  }
});
test('in one file', async () => {
  const { whole } = await run(block('In one file'), ['whole'], { container });
  assert.ok(whole.patchCount > 1);
});
test('errors', async () => {
  const { log } = console, lines = [];
  console.log = (...values) => lines.push(values);
  try {
    await run(block('Errors'), ['PsplitError'], { bytes: Uint8Array.from(container).fill(255, container.length - 60) });
  } finally {
    console.log = log;
  }
  assert.equal(lines[0][0], 'invalid-input');
  assert.ok(lines[0][2] > 0);
});

// The code runs in a page. Loaders also get a mesh in stock Draco beside the patches, as `gltf-psplit encode` writes it.
const mixed = with_draco_mesh(readFileSync(sample), stream);
const imports = { psplit: '/psplit/index.js', 'psplit/three': '/psplit/three.js', 'psplit/babylon': '/psplit/babylon.js', 'psplit/gltf': '/psplit/asset.js',
  three: '/modules/three/build/three.module.js', 'three/addons/': '/modules/three/examples/jsm/',
  '@babylonjs/core/': '/modules/@babylonjs/core/', '@babylonjs/loaders/': '/modules/@babylonjs/loaders/',
  playcanvas: '/modules/playcanvas/build/playcanvas.min.mjs', '@google/model-viewer': '/modules/@google/model-viewer/dist/model-viewer.min.js' };
const page = (code, names, model = { folder: sample }) => ({
  '/': `<!doctype html><meta charset="utf-8"><script type="importmap">${JSON.stringify({ imports })}</script>
    <script type="module" src="/main.js"></script>`,
  '/model.glb': model, '/mesh.drc': stream, '/block.js': `${code}\nexport { ${names} };`,
});

page_test('without a loader', { files: page(block('Without a loader'), ['primitives', 'decodeGlb']), script: async () => {
  const { log } = console, lines = [];
  console.log = (...values) => lines.push(values);
  const { primitives, decodeGlb } = await import('/block.js');
  console.log = log;
  const again = await decodeGlb(await (await fetch('/model.glb')).arrayBuffer());
  return [lines.length, lines[0][0], lines[0][3].length, primitives[0].attributes.POSITION.array.length, again.primitives.length];
} }, async ({ result }) => {
  const [count, name, ...lengths] = await result;
  assert.deepEqual([count, name, lengths[0], lengths[2]], [1, 'terrain', lengths[1], 1]);
});
const draco_indices = 3 * (await decodeDraco(stream)).faceCount;
page_test('three.js', { files: page(block('three.js'), ['scene', 'pool'], mixed), script: async () => {
  const { scene, pool } = await import('/block.js'), counts = [];
  scene.traverse((object) => { if (object.isMesh) counts.push(object.geometry.index.count); });
  pool.dispose();
  return counts;
} }, async ({ result }) => {
  const [patches, draco] = await result;
  assert.ok(patches > 1000);
  assert.equal(draco, draco_indices);
});
for (const [name, number] of [['three.js, patch by patch', 1], ['three.js, while bytes arrive', 2]])
  page_test(name, { files: page(block('three.js', number), ['scene', 'psplit'], mixed), script: async () => {
  const { scene, psplit } = await import('/block.js'), facts = [];
  scene.traverse((object) => { if (object.isMesh) facts.push([psplit.patchesOf(object)?.patchCount, object.geometry.index.count]); });
  return facts;
} }, async ({ result }) => {
  const [[patch_count], [of_draco, indices]] = await result;
  assert.ok(patch_count > 1);
  assert.deepEqual([of_draco ?? null, indices], [null, draco_indices]);
});
page_test('while bytes arrive', { files: page(block('Workers', 1), ['pool', 'primitives', 'triangles']), script: async () => {
  const { pool, primitives, triangles } = await import('/block.js');
  pool.dispose();
  return triangles.reduce((all, count) => all + count, 0) === primitives[0].faceCount;
} }, async ({ result }) => assert.equal(await result, true));
page_test('some patches only', { files: page(block('Workers', 2), ['primitives']), script: async () => {
  const { primitives: [{ faceCount, chosen }] } = await import('/block.js');
  return [faceCount > 0, chosen === undefined];
} }, async ({ result }) => assert.deepEqual(await result, [true, true]));  // the sample has no boxes
for (const i of [0, 1]) page_test(`Babylon.js ${i}`, { files: page(block('Babylon.js', i), ['meshes'], mixed), script: async () => {
  const { NullEngine } = await import('@babylonjs/core/Engines/nullEngine.js'), { Scene } = await import('@babylonjs/core/scene.js');
  globalThis.scene = new Scene(new NullEngine());
  const { meshes } = await import('/block.js');
  return meshes.map((mesh) => mesh.getTotalIndices()).filter((count) => count > 0);
} }, async ({ result }) => {
  const [patches, draco] = await result;
  assert.ok(patches > 1000);
  assert.equal(draco, draco_indices);
});
page_test('Babylon.js with psplit/draco', { files: page(block('Babylon.js', 2), ['DracoDecoder']), script: async () => {
  const { DracoDecoder } = await import('/block.js');
  const mesh = await DracoDecoder.Default.decodeMeshToMeshDataAsync(await (await fetch('/mesh.drc')).arrayBuffer());
  DracoDecoder.Default.dispose();
  return mesh.totalVertices;
} }, async ({ result, site }) => {
  assert.ok(await result > 100);
  assert.ok(site.requests.includes('/psplit/draco/draco_decoder.wasm'));
});
page_test('model-viewer', { files: { ...page(block('model-viewer'), []), '/draco.glb': draco_glb(stream) }, script: async () => {
  await import('/block.js');
  const loaded = async (element) => {
    const done = new Promise((resolve, reject) => {
      element.addEventListener('load', resolve);
      element.addEventListener('error', ({ detail }) => reject(new Error(JSON.stringify(detail))));
    });
    Object.assign(element, { src: '/draco.glb', loading: 'eager' });
    element.style.cssText = 'width: 100px; height: 100px; display: block';
    document.body.append(element);
    await done;
    return element.constructor.dracoDecoderLocation;
  };
  // Each element that is made sets the location.
  const first = await loaded(document.createElement('model-viewer'));
  return [first, await loaded(document.createElement('model-viewer'))];
} }, async ({ result, site }) => {
  assert.deepEqual(await result, ['/psplit/draco/', '/psplit/draco/']);
  assert.ok(site.requests.includes('/psplit/draco/draco_decoder.wasm'));
});
page_test('PlayCanvas', { files: page(block('PlayCanvas'), []), script: async () => {
  await import('/block.js');
  const { digest } = await import('/page.js'), stream = await (await fetch('/mesh.drc')).arrayBuffer();
  const decoded = ({ dracoDecode }) => new Promise((resolve, reject) => dracoDecode(stream.slice(), async (error, { indices, vertices }) =>
    (error ? reject(error) : resolve([await digest(new Uint8Array(indices)), await digest(new Uint8Array(vertices))]))));
  // Another PlayCanvas, on draco3d's files.
  const other = await import('/modules/playcanvas/build/playcanvas.min.mjs?other'), folder = '/modules/three/examples/jsm/libs/draco/';
  other.WasmModule.setConfig('DracoDecoderModule', { glueUrl: `${folder}draco_wasm_wrapper.js`, wasmUrl: `${folder}draco_decoder.wasm` });
  return [await decoded(await import('playcanvas')), await decoded(other)];
} }, async ({ result, site }) => {
  const [ours, theirs] = await result;
  assert.deepEqual(ours, theirs);
  assert.ok(site.requests.includes('/psplit/draco/draco_wasm_wrapper.js'));
});
page_test("three's DRACOLoader", { files: page(block('In place of draco3d'), ['loader']), script: async () => {
  const { loader } = await import('/block.js'), geometry = await loader.loadAsync('/mesh.drc');
  loader.dispose();
  return geometry.index.count;
} }, async ({ result, site }) => {
  assert.ok(await result > 100);
  assert.ok(site.requests.includes('/psplit/draco/draco_decoder.wasm'));
});

const cdn = await start_site({ headers: { 'Access-Control-Allow-Origin': '*' } });
after(() => cdn.close());
page_test('without a bundler', { files: {
  '/': `<!doctype html>${block('Without a bundler')
    .replaceAll('https://cdn.example/three/', `${cdn.origin}/modules/three/`).replaceAll('https://cdn.example/', `${cdn.origin}/`)
    .replace(/await loader.loadAsync.*\n/, (line) => `${line}  globalThis.found(scene);\n`)}
    <script>globalThis.result = new Promise((resolve) => (globalThis.found = ({ children }) => resolve(children.length)));</script>`,
  '/model.glb': mixed } }, async ({ result, page, site }) => {
  assert.equal(await result, 2);
  assert.ok(page.workers().length > 0);
  assert.ok(cdn.requests.includes('/psplit/inline.js') && !site.requests.some((url) => url.startsWith('/psplit/')));
});
page_test('preloading', { files: { '/': `<!doctype html><head>${block('Preloading')}</head><script type="module" src="/main.js"></script>`,
  '/model.glb': { folder: sample } }, script: async () => {
  const { createPool } = await import('/psplit/index.js'), pool = createPool();
  const { primitives } = await pool.decodeUrl('/model.glb');
  pool.dispose();
  return [primitives.length, ...['/model.glb', '/psplit/psplit.wasm'].map((url) =>
    performance.getEntriesByName(new URL(url, location).href).map(({ initiatorType }) => initiatorType))];
} }, async ({ result, site }) => {
  const [count, model, wasm] = await result;
  assert.deepEqual([count, model, wasm], [1, ['link'], ['link']]);
  for (const url of ['/model.glb', '/psplit/psplit.wasm', '/psplit/index.js'])
    assert.equal(site.requests.filter((request) => request === url).length, 1, url);
});

// The blocks of whole sections that other files test.
const elsewhere = { 'At the edge': 'edge_runtimes_test.mjs', React: 'react_test.mjs' };
test('each block is tested', () => {
  for (const [heading, file] of Object.entries(elsewhere)) {
    assert.ok(readFileSync(path.join(root, 'tests/web', file), 'utf8').includes(`readme_blocks()['${heading}']`), file);
    blocks[heading].forEach((_, i) => tested.add(`${heading} ${i}`));
  }
  const all = Object.entries(blocks).flatMap(([heading, list]) => list.map((_, i) => `${heading} ${i}`));
  assert.deepEqual([...tested].sort(), all.sort());
});
