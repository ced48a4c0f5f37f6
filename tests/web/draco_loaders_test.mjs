// The code with which Babylon.js, three.js and glTF-Transform decode Draco streams, on psplit/draco and on draco3d: all streams of
// the corpus, each file on a new module, whose memory is as small as it begins.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, corpus_folder, files_below, modules_folder, package_folder, read_asset, stock } from './load.mjs';
import { encode, grid } from './stock_draco.mjs';

const kExtension = 'KHR_draco_mesh_compression';
const require_module = createRequire(path.join(modules_folder, 'package.json'));
const module_of = (name) => import(pathToFileURL(path.join(modules_folder, 'node_modules', name)));
const { createDecoderModule } = createRequire(import.meta.url)(path.join(package_folder, 'draco/draco_wasm_wrapper.js'));
const kModules = { 'psplit/draco': createDecoderModule, draco3d: stock.createDecoderModule };

// Streams of the corpus with the attributes that their loaders ask for, as { file, streams: [{ bytes, attributes }] }. A .drc has none.
const files = [];
if (corpus_folder !== null) {
  for (const file of files_below(corpus_folder, /\.drc$/)) files.push({ file, streams: [{ bytes: new Uint8Array(readFileSync(file)) }] });
  for (const file of files_below(path.join(corpus_folder, 'gltf'), /\.(glb|gltf)$/)) {
    const streams = compressed_primitives(file, kExtension);
    if (streams.length > 0) files.push({ file, streams });
  }
}
// Without a corpus: a mesh whose arrays are larger than what the memory begins with.
const large = encode(grid(700), { method: 'edgebreaker', speed: 7, bits: 11, extra: true });
files.push({ file: 'a large grid', streams: [{ bytes: large }] });

// What a loader makes of each file, or its error's message, is the same on both modules.
async function same_on_both(load) {
  let count = 0;
  for (const { file, streams } of files) {
    const [ours, theirs] = await Promise.all(Object.values(kModules).map(async (create) => {
      const results = [], decode = await load(create);
      for (const stream of streams) results.push(await decode(stream).catch(({ message }) => ({ message })));
      return results;
    }));
    for (const [i, expected] of theirs.entries()) {
      const [major, minor] = streams[i].bytes.subarray(5), is_old = major * 10 + minor < 22;
      if (is_old) assert.match(ours[i].message, /is older than 2\.2/, file);  // draco_fallback_test.mjs
      else if (expected.message !== undefined) assert.ok(ours[i].message !== undefined, `${file} ${i}: draco3d says ${expected.message}`);
      else assert.deepEqual(ours[i], expected, `${file} ${i}: ${ours[i].message}`);
      count += expected.message === undefined ? 1 : 0;
    }
  }
  assert.ok(count >= files.length / 2, `${count} of ${files.length}`);
}

test("Babylon.js' DecodeMesh", async () => {
  const { DecodeMesh } = await module_of('@babylonjs/core/Meshes/Compression/dracoCompressionWorker.js');
  await same_on_both(async (create) => {
    const module = await create({});
    return async ({ bytes, attributes }) => {
      const ids = attributes && Object.fromEntries(attributes.map(({ name, uniqueId }) => [name, uniqueId])), result = {};
      result.points = DecodeMesh(module, new Int8Array(bytes), ids, (indices) => (result.indices = indices),
        (...attribute) => (result[attribute[0]] = attribute));
      return result;
    };
  });
});

test("three's DRACOLoader", async () => {
  const text = readFileSync(path.join(modules_folder, 'node_modules/three/examples/jsm/loaders/DRACOLoader.js'), 'utf8');
  const [worker] = text.match(/^function DRACOWorker\(\) \{.*?^\}/ms);
  await same_on_both(async (create) => {
    let settle;
    const self = { ...Object.fromEntries([Float32Array, Int8Array, Uint8Array, Int16Array, Uint16Array, Int32Array, Uint32Array].map((Type) => [Type.name, Type])),
      postMessage: (message) => settle(message) };
    const quiet = { error() {} };
    const onmessage = new Function('DracoDecoderModule', 'self', 'console', `let onmessage; ${worker}; DRACOWorker(); return onmessage;`)(create, self, quiet);
    onmessage({ data: { type: 'init', decoderConfig: {} } });
    return async ({ bytes, attributes }) => {
      const type_of = (type) => `${type[0].toUpperCase()}${type.slice(1)}Array`, entries = attributes?.map((of) => [of.name.toLowerCase(), of]);
      const taskConfig = attributes ? { attributeIDs: Object.fromEntries(entries.map(([name, { uniqueId }]) => [name, uniqueId])),
        attributeTypes: Object.fromEntries(entries.map(([name, { type }]) => [name, type_of(type)])), useUniqueIDs: true }
        : { attributeIDs: { position: 'POSITION', normal: 'NORMAL', color: 'COLOR', uv: 'TEX_COORD' }, useUniqueIDs: false,
          attributeTypes: { position: 'Float32Array', normal: 'Float32Array', color: 'Float32Array', uv: 'Float32Array' } };
      const done = new Promise((resolve) => (settle = resolve));
      onmessage({ data: { type: 'decode', id: 1, buffer: bytes.slice().buffer, taskConfig } });
      const { geometry, error } = await done;
      if (error !== undefined) throw new Error(error);
      return geometry;
    };
  });
});

const assets = files.map(({ file }) => file).filter((file) => /\.(glb|gltf)$/.test(file));
test("glTF-Transform's KHRDracoMeshCompression", { skip: assets.length === 0 && 'there is no corpus' }, async () => {
  const { NodeIO } = await module_of('@gltf-transform/core/dist/index.js');
  const { ALL_EXTENSIONS } = await module_of('@gltf-transform/extensions/dist/index.js');
  const { MeshoptDecoder } = require_module('meshoptimizer');
  const nothing = () => {}, facts = (accessor) => accessor && [accessor.getType(), accessor.getNormalized(), accessor.getArray()];
  const known = assets.filter((file) => !read_asset(file).json.extensionsRequired?.some((name) => /^PSPLIT|^EXT_mesh_gpu/.test(name)));
  assert.ok(known.length > 0);
  for (const file of known) {
    const [ours, theirs] = await Promise.all(Object.values(kModules).map(async (create) => {
      const io = new NodeIO().setLogger({ debug: nothing, info: nothing, error: nothing, warn: nothing }).registerExtensions(ALL_EXTENSIONS)
        .registerDependencies({ 'draco3d.decoder': await create(), 'meshopt.decoder': MeshoptDecoder });
      try {
        const document = await io.read(file);
        return document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives()).map((primitive) => [facts(primitive.getIndices()),
          ...primitive.listSemantics().sort().map((name) => [name, facts(primitive.getAttribute(name))])]);
      } catch ({ message }) {
        return { message };
      }
    }));
    if (theirs.message !== undefined) assert.ok(ours.message !== undefined, `${file}: draco3d says ${theirs.message}`);
    else assert.deepEqual(ours, theirs, `${file}: ${ours.message}`);
  }
});
