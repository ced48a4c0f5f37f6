// The drop-in for draco3d's decoder: the same calls have the same results, and loaders run on it unmodified.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { BlobWorker } from './blob_worker.mjs';
import { compressed_primitives, corpus_folder, files_below, modules_folder, package_folder, root, stock } from './load.mjs';
import { streams } from './stock_draco.mjs';

const folder = path.join(package_folder, 'draco');
const { createDecoderModule } = createRequire(import.meta.url)(path.join(folder, 'draco_wasm_wrapper.js'));
const ours = await createDecoderModule(), theirs = await stock.createDecoderModule({});
const conformance = readFileSync(path.join(root, 'web/js/draco/conformance.md'), 'utf8');

// Everything that a page can ask of a decoded mesh, by the calls of draco3d.
function ask(draco, bytes, skipped = []) {
  const decoder = new draco.Decoder(), mesh = new draco.Mesh(), buffer = new draco.DecoderBuffer();
  const answers = {};
  try {
    for (const semantic of skipped) decoder.SkipAttributeTransform(draco[semantic]);
    buffer.Init(new Int8Array(bytes), bytes.length);
    answers.kinds = [decoder.GetEncodedGeometryType(buffer), decoder.GetEncodedGeometryType(new Int8Array(bytes))];
    const status = decoder.DecodeBufferToMesh(buffer, mesh);
    answers.ok = [status.ok(), status.code() === draco.OK];
    if (!status.ok()) return answers;
    answers.counts = [mesh.num_faces(), mesh.num_points(), mesh.num_attributes()];
    const [faces, points] = answers.counts;
    const memory = (size, write) => {
      const at = draco._malloc(size);
      const written = write(size, at);
      const result = written === false ? false : draco.HEAPU8.slice(at, at + size);
      draco._free(at);
      return result;
    };
    answers.triangles = memory(12 * faces, (size, at) => void decoder.GetTrianglesUInt32Array(mesh, size, at));
    answers.triangles_16 = memory(6 * faces, (size, at) => void decoder.GetTrianglesUInt16Array(mesh, size, at));
    answers.wrong_size = decoder.GetTrianglesUInt32Array(mesh, 12 * faces - 4, 0);
    const face = new draco.DracoInt32Array();
    answers.face = [decoder.GetFaceFromMesh(mesh, faces - 1, face), face.GetValue(0), face.GetValue(1), face.GetValue(2)];
    answers.ids = ['POSITION', 'NORMAL', 'COLOR', 'TEX_COORD', 'GENERIC'].map((name) => decoder.GetAttributeId(mesh, draco[name]));
    answers.attributes = Array.from({ length: mesh.num_attributes() }, (_, i) => {
      const attribute = decoder.GetAttribute(mesh, i);
      const facts = [attribute.attribute_type(), attribute.data_type(), attribute.num_components(), attribute.normalized(),
        attribute.unique_id(), attribute.byte_stride()];
      assert.equal(decoder.GetAttributeByUniqueId(mesh, attribute.unique_id()).unique_id(), attribute.unique_id());
      const arrays = {};
      for (const [type, bytes_each] of [['INT8', 1], ['UINT8', 1], ['INT16', 2], ['UINT16', 2], ['INT32', 4], ['UINT32', 4], ['FLOAT32', 4]])
        arrays[type] = memory(points * attribute.num_components() * bytes_each, (size, at) =>
          decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco[`DT_${type}`], size, at));
      const floats = new draco.DracoFloat32Array(), integers = new draco.DracoInt32Array();
      const values = [decoder.GetAttributeFloatForAllPoints(mesh, attribute, floats), floats.size(), floats.GetValue(floats.size() - 1)];
      if (attribute.data_type() !== draco.DT_FLOAT32)
        values.push(decoder.GetAttributeInt32ForAllPoints(mesh, attribute, integers), integers.size(), integers.GetValue(0));
      const quantization = new draco.AttributeQuantizationTransform(), octahedron = new draco.AttributeOctahedronTransform();
      const transforms = [quantization.InitFromAttribute(attribute), octahedron.InitFromAttribute(attribute)];
      if (transforms[0]) transforms.push(quantization.quantization_bits(), quantization.range(), ...[0, 1, 2].slice(0, attribute.num_components()).map((axis) => quantization.min_value(axis)));
      if (transforms[1]) transforms.push(octahedron.quantization_bits());
      return { facts, arrays, values, transforms };
    });
    return answers;
  } finally {
    for (const object of [buffer, mesh, decoder]) draco.destroy(object);
  }
}

test('the same answers as draco3d', () => {
  for (const [name, bytes] of streams()) assert.deepEqual(ask(ours, bytes), ask(theirs, bytes), name);
});

test('the same answers if transforms are skipped', () => {
  for (const [name, bytes] of streams())
    if (name.includes('11 bits'))
      assert.deepEqual(ask(ours, bytes, ['POSITION', 'NORMAL', 'TEX_COORD']), ask(theirs, bytes, ['POSITION', 'NORMAL', 'TEX_COORD']), name);
});

test('every member of draco3d is there, or the list says why not', () => {
  const members = (draco) => Object.keys(draco).flatMap((name) => {
    if (/^_|^(asm|calledRun|ready|inspect|getCache|onModuleParsed|onRuntimeInitialized|then)$/.test(name)) return [];  // emscripten's own
    const of_class = typeof draco[name] === 'function' ? Object.getOwnPropertyNames(draco[name].prototype ?? {}) : [];
    return [name, ...of_class.filter((member) => !/^(constructor|__)/.test(member)).map((member) => `${name}.${member}`)];
  });
  const own = new Set(members(ours));
  for (const name of ['HEAP8', 'HEAPU8', 'HEAP16', 'HEAPU16', 'HEAP32', 'HEAPU32', 'HEAPF32', 'HEAPF64']) own.add(name);
  // A class of ours may inherit a member.
  const has = (name) => own.has(name) || (name.includes('.') && name.split('.')[1] in (ours[name.split('.')[0]]?.prototype ?? {}));
  const absent = members(theirs).filter((name) => !has(name));
  assert.deepEqual(absent.filter((name) => !conformance.includes(`| \`${name}\` | absent`)), []);
  for (const name of absent) assert.ok(!own.has(name));
  for (const [name, value] of Object.entries(theirs)) if (typeof value === 'number' && !name.startsWith('_')) assert.equal(ours[name], value, name);
});

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
  assert.equal(new ours.Decoder().GetEncodedGeometryType(new Int8Array(20)), ours.INVALID_GEOMETRY_TYPE);
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
