// The drop-in for draco3d's decoder: the same calls have the same results, and loaders run on it unmodified.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { BlobWorker } from './blob_worker.mjs';
import { ask } from './draco_answers.mjs';
import { test_list } from './draco_members.mjs';
import { compressed_primitives, corpus_folder, files_below, modules_folder, package_folder, root, stock } from './load.mjs';
import { streams } from './stock_draco.mjs';

const folder = path.join(package_folder, 'draco');
const { createDecoderModule } = createRequire(import.meta.url)(path.join(folder, 'draco_wasm_wrapper.js'));
const ours = await createDecoderModule(), theirs = await stock.createDecoderModule({});
const newest = createRequire(path.join(modules_folder, 'package.json'))('draco3d-newest');

test('the same answers as draco3d', () => {
  for (const [name, bytes] of streams()) assert.deepEqual(ask(ours, bytes), ask(theirs, bytes), name);
});

test('the same answers if transforms are skipped', () => {
  for (const [name, bytes] of streams())
    if (name.includes('11 bits'))
      assert.deepEqual(ask(ours, bytes, ['POSITION', 'NORMAL', 'TEX_COORD']), ask(theirs, bytes, ['POSITION', 'NORMAL', 'TEX_COORD']), name);
});

test_list('conformance.md', ours, { '1.5.7': theirs, '1.5.9': await newest.createDecoderModule({}) }, 90);

test('several live meshes', () => {
  const decoder = new ours.Decoder(), [first, second] = [...streams()].map(([, bytes]) => bytes);
  const meshes = [first, second, first].map((bytes) => {
    const mesh = new ours.Mesh();
    assert.ok(decoder.DecodeArrayToMesh(bytes, bytes.length, mesh).ok());
    return mesh;
  });
  const floats = meshes.map((mesh) => {
    const out = new ours.DracoFloat32Array();
    decoder.GetAttributeFloatForAllPoints(mesh, decoder.GetAttribute(mesh, 0), out);
    return Array.from({ length: out.size() }, (_, i) => out.GetValue(i));
  });
  assert.deepEqual(floats[0], floats[2]);
  for (const mesh of meshes) ours.destroy(mesh);
});

test('faults are a status', () => {
  const [[, bytes]] = streams();
  const status_of = (data) => {
    const decoder = new ours.Decoder(), mesh = new ours.Mesh();
    const status = decoder.DecodeArrayToMesh(data, data.length, mesh);
    ours.destroy(mesh);
    return [status.ok(), status.code(), status.error_msg()];
  };
  assert.deepEqual(status_of(bytes), [true, ours.OK, '']);
  const older = Uint8Array.from(bytes), cut = bytes.slice(0, 100);
  older[6] = 1;
  assert.deepEqual(status_of(older).slice(0, 2), [false, ours.UNSUPPORTED_VERSION]);
  assert.match(status_of(older)[2], /bitstream 2\.1/);
  assert.deepEqual(status_of(cut), [false, ours.DRACO_ERROR, 'psplit: Draco stream: the stream ends early']);
  assert.equal(ours.GetAttribute, undefined);
});

test('memory comes back', () => {
  const [[, bytes]] = streams();
  ask(ours, bytes);
  const before = ours.HEAPU8.length;
  for (let i = 0; i < 200; ++i) ask(ours, bytes);
  assert.equal(ours.HEAPU8.length, before);
});

test("three's DRACOLoader", async () => {
  const server = createServer((request, response) => response.end(readFileSync(path.join(folder, path.basename(request.url)))));
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  globalThis.Worker = BlobWorker;
  globalThis.ProgressEvent ??= class extends Event {};
  globalThis.self ??= globalThis;
  const { DRACOLoader } = await import(pathToFileURL(path.join(modules_folder, 'node_modules/three/examples/jsm/loaders/DRACOLoader.js')));
  const loader = new DRACOLoader().setDecoderPath(`http://127.0.0.1:${server.address().port}/`).setWorkerLimit(2);
  const parse = (bytes) => new Promise((resolve, reject) => loader.parse(Uint8Array.from(bytes).buffer, resolve, reject));
  try {
    const chosen = [...streams()].filter(([name]) => name.includes('more attributes'));
    const geometries = await Promise.all(chosen.map(([, bytes]) => parse(bytes)));
    for (const [i, [name, bytes]] of chosen.entries()) {
      const answers = ask(theirs, bytes), geometry = geometries[i];
      assert.deepEqual(new Uint8Array(geometry.index.array.buffer), answers.triangles, name);
      for (const [attribute, semantic] of [['position', 0], ['normal', 1], ['uv', 3]]) {
        const expected = answers.attributes.find(({ facts }) => facts[0] === semantic).arrays.FLOAT32;
        assert.deepEqual(new Uint8Array(geometry.getAttribute(attribute).array.buffer), expected, `${name}: ${attribute}`);
      }
    }
  } finally {
    loader.dispose();
    server.close();
  }
});

test("glTF-Transform's KHR_draco_mesh_compression", { skip: corpus_folder === null && 'there is no corpus' }, async () => {
  const load = (name) => import(pathToFileURL(path.join(modules_folder, `node_modules/@gltf-transform/${name}/dist/index.js`)));
  const { NodeIO } = await load('core'), { KHRDracoMeshCompression, KHRONOS_EXTENSIONS } = await load('extensions');
  const read = async (file, decoder) => {
    const io = new NodeIO().registerExtensions(KHRONOS_EXTENSIONS).registerDependencies({ 'draco3d.decoder': decoder });
    const document = await io.read(file);
    return document.getRoot().listAccessors().map((accessor) => [accessor.getName(), accessor.getType(), accessor.getArray()]);
  };
  assert.ok(KHRDracoMeshCompression);
  let count = 0;
  for (const file of files_below(path.join(corpus_folder, 'gltf'), /draco.*\.(glb|gltf)$/i)) {
    try {
      if (compressed_primitives(file, 'KHR_draco_mesh_compression').some(({ bytes }) => bytes[6] !== 2)) continue;
    } catch {
      continue;  // a broken asset
    }
    assert.deepEqual(await read(file, ours), await read(file, theirs), file);
    ++count;
  }
  assert.ok(count >= 4, `${count} assets`);
});
