// psplit/gltf: whole assets as typed arrays, which equal the arrays of the native decoder, of draco3d and of glTF-Transform.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { page_test } from './browser.mjs';
import { corpus_folder, files_below, modules_folder, package_folder, psplit, random_numbers, root, stock } from './load.mjs';
import { decode, draco_glb, make_glb, streams } from './stock_draco.mjs';

const { decodeGlb, decodeGltf } = await import(pathToFileURL(path.join(package_folder, 'asset.js')));
const load = (name) => import(pathToFileURL(path.join(modules_folder, 'node_modules', name)));
const { MeshoptDecoder, MeshoptEncoder } = await load('meshoptimizer/index.js');
await MeshoptEncoder.ready;
const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples'), sample = (name) => path.join(samples, name);
const expected = JSON.parse(readFileSync(sample('expected.json')));
const hash = (array) => createHash('sha256').update(new Uint8Array(array.buffer, array.byteOffset, array.byteLength)).digest('hex');
const kInvalid = { name: 'PsplitError', code: 'invalid-input' };
const pool = psplit.createPool({ workers: 2 });
after(() => pool.dispose());

function assert_sample(name, { primitives }) {
  const [{ points, indices_sha256, attributes_sha256, targets_sha256 }] = expected[name].primitives, [{ coding, mode, pointCount, indices, attributes, targets }] = primitives;
  assert.deepEqual([coding, mode, pointCount, hash(Uint32Array.from(indices))], ['patches', 4, points, indices_sha256], name);
  assert.deepEqual(Object.fromEntries(Object.entries(attributes).map(([attribute, { array }]) => [attribute, hash(array)])), attributes_sha256, name);
  assert.equal(targets === undefined, targets_sha256 === undefined);
  for (const [target, digest] of Object.entries(targets_sha256 ?? {})) {
    const [, t, attribute] = target.split('/');
    assert.equal(hash(targets[t][attribute].array), digest, `${name}: ${target}`);
  }
}
test('samples in patches', async () => {
  assert.ok(Object.keys(expected).length > 7);
  for (const name of Object.keys(expected)) {
    assert_sample(name, await decodeGltf(pathToFileURL(sample(name))));
    assert_sample(name, await decodeGltf(pathToFileURL(sample(name)).href, { pool }));
    if (name.endsWith('.glb')) assert_sample(name, await decodeGlb(readFileSync(sample(name)), null));
  }
});

test('morph targets that are zero, sparse, or in buffer views', async () => {
  const { primitives: [{ targets: [, , zero] }] } = await decodeGlb(readFileSync(sample('targets.glb')));
  assert.deepEqual([zero.POSITION.type, zero.POSITION.array], ['float32', new Float32Array(3 * 126)]);
  const with_targets = (change = () => {}) => decodeGlb(glb_of((json) => {
    json.accessors.push({ ...json.accessors[2] });
    delete json.accessors[3].bufferView;
    json.meshes[0].primitives[0].targets = [{ POSITION: 2, NORMAL: 3 }, {}, { POSITION: 0 }];
    change(json.accessors[3]);
  }));
  const { primitives: [{ targets }, { targets: none }] } = await with_targets();
  assert.deepEqual(targets.map((target) => Object.entries(target).map(([name, { array }]) => [name, array])),
    [[['POSITION', Float32Array.of(0, 1, 2, -1, -2, -3, 6, 7, 8)], ['NORMAL', Float32Array.of(0, 0, 0, -1, -2, -3, 0, 0, 0)]], [],
      [['POSITION', Float32Array.of(0, 1, 2, 3, 4, 5, 6, 7, 8)]]]);
  assert.equal(none, undefined);
  // No memory is taken for zeros that nothing justifies.
  await assert.rejects(with_targets((accessor) => (accessor.count = 2 ** 40)), { code: 'unsupported', message: /accessor 3 has 1099511627776 elements without a buffer view/ });
});

test('stock Draco', async () => {
  for (const [name, stream] of streams()) {
    const theirs = decode(stream);
    for (const options of [{}, { pool }]) {
      const { primitives: [{ coding, pointCount, indices, attributes }] } = await decodeGlb(draco_glb(stream), options);
      assert.deepEqual({ coding, pointCount, indices, position: attributes.POSITION.array },
        { coding: 'draco', pointCount: theirs.pointCount, indices: theirs.indices, position: theirs.attributes[0].array }, name);
    }
  }
});

// An asset without compression: gaps between elements, a sparse accessor, several buffers.
const floats = Float32Array.of(0, 1, 2, 9, 3, 4, 5, 9, 6, 7, 8);
const plain = () => ({
  asset: { version: '2.0' }, buffers: [{ byteLength: 44 }, { byteLength: 6, uri: `data:application/octet-stream;base64,${Buffer.from(Uint16Array.of(2, 1, 0).buffer).toString('base64')}` },
    { byteLength: 16, uri: `data:,${[...new Uint8Array(Uint32Array.of(1, ...new Uint32Array(Float32Array.of(-1, -2, -3).buffer)).buffer)].map((byte) => (byte < 128 ? `%${byte.toString(16).padStart(2, '0')}` : String.fromCharCode(byte))).join('')}` }],
  bufferViews: [{ buffer: 0, byteLength: 44, byteStride: 16 }, { buffer: 1, byteLength: 6 }, { buffer: 2, byteLength: 4 }, { buffer: 2, byteOffset: 4, byteLength: 12 }],
  accessors: [{ bufferView: 0, componentType: 5126, type: 'VEC3', count: 3 }, { bufferView: 1, componentType: 5123, type: 'SCALAR', count: 3 },
    { bufferView: 0, componentType: 5126, type: 'VEC3', count: 3,
      sparse: { count: 1, indices: { bufferView: 2, componentType: 5125 }, values: { bufferView: 3 } } }],
  meshes: [{ name: 'plain', primitives: [{ attributes: { POSITION: 0, _SPARSE: 2 }, indices: 1, material: 7 }, { mode: 0, attributes: { POSITION: 0 } }] }],
});
const glb_of = (change = () => {}) => {
  const json = plain();
  change(json);
  return make_glb(json, new Uint8Array(floats.buffer));
};
test('primitives without compression', async () => {
  const { json, primitives: [triangles, points] } = await decodeGlb(glb_of());
  assert.equal(json.meshes[0].name, 'plain');
  assert.deepEqual(triangles, { mesh: 0, primitive: 0, mode: 4, material: 7, coding: 'none', pointCount: 3, indices: Uint16Array.of(2, 1, 0), attributes: {
    POSITION: { type: 'float32', componentCount: 3, normalized: false, array: Float32Array.of(0, 1, 2, 3, 4, 5, 6, 7, 8) },
    _SPARSE: { type: 'float32', componentCount: 3, normalized: false, array: Float32Array.of(0, 1, 2, -1, -2, -3, 6, 7, 8) } } });
  assert.deepEqual([points.mode, points.indices, points.pointCount], [0, null, 3]);
});

test('accessors without a buffer view are 0', async () => {
  const { primitives: [{ indices, attributes }] } = await decodeGlb(glb_of(({ accessors }) => {
    for (const i of [0, 1, 2]) delete accessors[i].bufferView;
  }));
  assert.deepEqual([indices, attributes.POSITION.array, attributes._SPARSE.array],
    [new Uint16Array(3), new Float32Array(9), Float32Array.of(0, 0, 0, -1, -2, -3, 0, 0, 0)]);
});

// plain() with its positions and its indices compressed by meshoptimizer. The decoded bytes may be in the file as well.
function meshopt_glb(extension, { required = true, plain_bytes = new Uint8Array(0), change = () => {} } = {}) {
  const json = plain(), positions = new Uint8Array(floats.buffer.slice(0, 44)), rows = new Uint8Array(48);
  rows.set(positions);
  const views = [[rows, 'ATTRIBUTES', 16, 3, MeshoptEncoder.encodeGltfBuffer(rows, 3, 16, 'ATTRIBUTES')],
    [null, 'TRIANGLES', 2, 3, MeshoptEncoder.encodeGltfBuffer(new Uint8Array(Uint16Array.of(2, 1, 0).buffer), 3, 2, 'TRIANGLES')]];
  const bytes = [...plain_bytes], { length } = plain_bytes;
  views.forEach(([, mode, byteStride, count, compressed], i) => {
    json.bufferViews[i] = { buffer: length > 0 ? 0 : 3, byteOffset: 64 * i, byteLength: i === 0 ? 44 : 6, ...(i === 0 && { byteStride }),
      extensions: { [extension]: { buffer: 0, byteOffset: bytes.length, byteLength: compressed.length, byteStride, count, mode } } };
    bytes.push(...compressed);
  });
  json.buffers[0].byteLength = bytes.length;
  json.buffers.push({ byteLength: 128, extensions: { [extension]: { fallback: true } } });
  Object.assign(json, { extensionsUsed: [extension] }, required && { extensionsRequired: [extension] });
  change(json);
  return make_glb(json, Uint8Array.from(bytes));
}
test('views that meshoptimizer compressed', async () => {
  const { primitives: expected_primitives } = await decodeGlb(glb_of());
  const rotated = ([{ indices }]) => [0, 1, 2].some((k) => [2, 1, 0].every((point, i) => indices[(i + k) % 3] === point));
  for (const extension of ['EXT_meshopt_compression', 'KHR_meshopt_compression']) {
    for (const options of [{ meshoptDecoder: MeshoptDecoder }, { meshoptDecoder: MeshoptDecoder, pool }]) {
      const { primitives } = await decodeGlb(meshopt_glb(extension), options);
      assert.ok(rotated(primitives), extension);
      primitives[0].indices = expected_primitives[0].indices;
      assert.deepEqual(primitives, expected_primitives);
    }
    await assert.rejects(decodeGlb(meshopt_glb(extension)), { name: 'PsplitError', code: 'unsupported',
      message: new RegExp(`buffer view [01] has ${extension}: the option \`meshoptDecoder\` has to be a decoder`) });
    const plain_bytes = new Uint8Array(72);
    plain_bytes.set(new Uint8Array(floats.buffer));
    plain_bytes.set(new Uint8Array(Uint16Array.of(2, 1, 0).buffer), 64);
    // Loaders without the extension read what the file has as well, unless the asset requires it.
    assert.deepEqual((await decodeGlb(meshopt_glb(extension, { required: false, plain_bytes }))).primitives, expected_primitives);
    await assert.rejects(decodeGlb(meshopt_glb(extension, { plain_bytes })), { code: 'unsupported' });
    await assert.rejects(decodeGlb(meshopt_glb(extension, { required: false })), { code: 'unsupported' });
    for (const [change, message] of [[(of) => (of.count = 2 ** 40), /more bytes than/], [(of) => (of.count = 2), /of no valid mode, filter, byteStride or count/],
      [(of) => (of.byteStride = 260), /of no valid mode/], [(of) => (of.mode = 'TRIANGLES'), /of no valid mode/], [(of) => (of.mode = 'TOSTRING'), /of no valid mode/],
      [(of) => (of.byteLength = 2 ** 30), /buffer view 0 is not in its buffer/], [(of) => (of.byteLength -= 1), /cannot be decoded/],
      [(of) => (of.filter = 'SOME'), /of no valid mode/]]) {
      const glb = meshopt_glb(extension, { change: (json) => change(json.bufferViews[0].extensions[extension]) });
      await assert.rejects(decodeGlb(glb, { meshoptDecoder: MeshoptDecoder }), { ...kInvalid, message });
    }
  }
});

test('what is wrong is said', async () => {
  const cases = [
    [(json) => { json.accessors[0] = { ...json.accessors[0], bufferView: undefined, count: 2 ** 40 }; }, 'unsupported',
      /^mesh 0 "plain", primitive 0: accessor 0 has 1099511627776 elements without a buffer view$/],
    [(json) => (json.accessors[0].count = 4), 'invalid-input', /^mesh 0 "plain", primitive 0: an accessor is not in its buffer view$/],
    [(json) => (json.accessors[0].count = 2 ** 40), 'invalid-input', /not in its buffer view/],
    [(json) => (json.bufferViews[0].byteStride = 0), 'invalid-input', /not in its buffer view/],
    [(json) => (json.bufferViews[0].byteLength = 45), 'invalid-input', /buffer view 0 is not in its buffer/],
    [(json) => (json.accessors[1].type = 'VEC9'), 'invalid-input', /accessor 1 has no valid type/],
    [(json) => (json.buffers[1].uri = 'a.bin'), 'invalid-input', /buffer 1 is in the file a\.bin: the option `url`/],
    [(json) => Object.assign(json, { extensionsRequired: ['EXT_meshopt_compression'] }).bufferViews[1].extensions = { EXT_meshopt_compression: {} },
      'unsupported', /buffer view 1 has EXT_meshopt_compression: the option `meshoptDecoder`/],
    [(json) => (json.meshes[0].primitives[0] = null), 'invalid-input', /malformed/],
    [(json) => (json.meshes = 5), 'invalid-input', /malformed/],
  ];
  for (const [change, code, message] of cases) await assert.rejects(decodeGlb(glb_of(change)), { name: 'PsplitError', code, message });
  await assert.rejects(decodeGlb(new TextEncoder().encode('<!doctype html>')), { ...kInvalid, message: /^not a glTF asset: / });
  await assert.rejects(decodeGltf('file:///nowhere/a.glb'), { code: 'failed', message: /^file:\/\/\/nowhere\/a\.glb cannot be loaded: ENOENT/ });
  for (const url of [undefined, null, 'relative.glb']) await assert.rejects(decodeGltf(url), kInvalid);
  for (const data of [null, 'text']) await assert.rejects(decodeGlb(data), kInvalid);
  for (const options of [{}, { pool }])
    await assert.rejects(decodeGlb(readFileSync(sample('patches.glb')), { ...options, signal: AbortSignal.abort() }), { code: 'aborted' });
  const controller = new AbortController(), job = assert.rejects(decodeGltf(pathToFileURL(sample('patches.glb')), { pool, signal: controller.signal }), { code: 'aborted' });
  controller.abort();
  await job;
  const broken = Uint8Array.from(readFileSync(sample('patches.glb')));
  broken.fill(0xff, broken.length - 60);
  await assert.rejects(decodeGlb(broken), ({ name, message, patch }) => name === 'PsplitError' && /^mesh 0 "terrain", primitive 0: patch \d+: /.test(message) && patch > 0);
});

test('a fallback is read if the patches are of a newer version', async () => {
  const json = JSON.parse(readFileSync(sample('fallback.gltf'))), files = json.buffers.map(({ uri }) => new Uint8Array(readFileSync(sample(uri))));
  const asset = (change) => {
    change(files[0]);
    json.buffers.forEach((buffer, i) => (buffer.uri = `data:application/octet-stream;base64,${Buffer.from(files[i]).toString('base64')}`));
    return new TextEncoder().encode(JSON.stringify(json));
  };
  const { primitives: [whole] } = await decodeGlb(asset(() => {}));
  const { primitives: [fallback] } = await decodeGlb(asset((container) => (container[4] = 99)));
  assert.deepEqual([whole.coding, fallback.coding, whole.pointCount], ['patches', 'none', fallback.pointCount]);
  assert.deepEqual(Object.keys(fallback.attributes), Object.keys(whole.attributes));
});

test('coarse primitives are not read', async () => {
  const glb = new Uint8Array(readFileSync(sample('coarse.glb'))), text = Buffer.from(glb).toString('latin1');
  const without = (json) => decodeGlb(Buffer.from(text.replace(...json), 'latin1'));
  assert.equal((await decodeGlb(glb)).primitives.length, 1);
  // As many bytes in place of the list of primitives.
  await assert.rejects(without(['"PSPLIT_mesh_draco_patches":{"primitives":', '"PSPLIT_mesh_draco_patches":{"primitiveS":']),
    { ...kInvalid, message: 'mesh 0: PSPLIT_mesh_draco_patches of a mesh has no list of primitives' });
});

test('any bytes give an asset or a PsplitError', async () => {
  const random = random_numbers(3);
  for (const glb of [glb_of(), draco_glb([...streams()][0][1]), new Uint8Array(readFileSync(sample('seams.glb'))), meshopt_glb('EXT_meshopt_compression')])
    for (let round = 0; round < 300; ++round) {
      const bytes = round % 3 === 0 ? glb.slice(0, random(glb.length)) : Uint8Array.from(glb);
      for (let left = random(4); left >= 0 && bytes.length > 0; --left) bytes[random(Math.min(bytes.length, round % 2 === 0 ? 1500 : Infinity))] = random(256);
      await decodeGlb(bytes, { meshoptDecoder: MeshoptDecoder }).catch((error) => assert.equal(error.name, 'PsplitError', error.stack));
    }
});

test('assets of the corpus are those of glTF-Transform', { skip: corpus_folder === null && 'there is no corpus' }, async () => {
  const { NodeIO, Logger } = await load('@gltf-transform/core/dist/index.js'), { ALL_EXTENSIONS } = await load('@gltf-transform/extensions/dist/index.js');
  const io = new NodeIO().registerExtensions(ALL_EXTENSIONS)
    .registerDependencies({ 'draco3d.decoder': await stock.createDecoderModule({}), 'meshopt.decoder': MeshoptDecoder })
    .setLogger(new Logger(Logger.Verbosity.SILENT));
  const counts = { draco: 0, none: 0, meshopt: 0 };
  for (const file of files_below(path.join(corpus_folder, 'gltf'), /\.(glb|gltf)$/)) {
    const document = await io.read(file).catch(() => null), ours = await decodeGltf(pathToFileURL(file), { meshoptDecoder: MeshoptDecoder }).catch((error) => error);
    if (document === null) continue;  // a broken asset, or one whose extension is not known there
    if (ours instanceof Error) {
      assert.ok(ours.name === 'PsplitError' && ours.code === 'unsupported', `${file}: ${ours.stack}`);
      continue;
    }
    const theirs = document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives());
    assert.equal(ours.primitives.length, theirs.length, file);
    counts.meshopt += ours.json.extensionsUsed?.includes('EXT_meshopt_compression') ?? 0;
    for (const [i, { coding, indices, attributes, targets }] of ours.primitives.entries()) {
      ++counts[coding];
      assert.deepEqual(indices && Uint32Array.from(indices), theirs[i].getIndices() && Uint32Array.from(theirs[i].getIndices().getArray()), file);
      for (const name of theirs[i].listSemantics())
        assert.deepEqual(attributes[name].array, theirs[i].getAttribute(name).getArray(), `${file}: ${name}`);
      for (const [t, target] of theirs[i].listTargets().entries())
        for (const name of target.listSemantics())
          assert.deepEqual(targets[t][name].array, target.getAttribute(name).getArray(), `${file}: target ${t}, ${name}`);
    }
  }
  assert.ok(counts.draco > 20 && counts.none > 100 && counts.meshopt > 4, JSON.stringify(counts));
});

page_test('a page that loads a .gltf with its files', { files: { '/samples/': { folder: samples } },
  headers: { 'Content-Security-Policy': "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'" }, script: async () => {
    const { createPool } = await import('/psplit/index.js'), { decodeGltf } = await import('/psplit/asset.js');
    const pool = createPool({ workers: 1 });
    const assets = [await decodeGltf('/samples/fallback.gltf', { pool }), await decodeGltf(new URL('/samples/patches.glb', location.href))];
    pool.dispose();
    return assets.map(({ primitives: [{ pointCount, coding }] }) => [pointCount, coding]);
  } }, async ({ result }) => assert.deepEqual(await result, ['fallback.gltf', 'patches.glb'].map((name) => [expected[name].primitives[0].points, 'patches'])));
