// The extension for glTF-Transform: it reads what gltf-psplit reads, and keeps containers whose geometry did not change.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, corpus_folder, files_below, fine_primitives, gltf_psplit, modules_folder, package_folder, psplit, read_asset, root } from './load.mjs';

const require_module = createRequire(path.join(modules_folder, 'package.json'));
const load = (name) => import(pathToFileURL(path.join(modules_folder, `node_modules/${name}`)));
const { Document, NodeIO } = await load('@gltf-transform/core/dist/index.js');
const { ALL_EXTENSIONS, EXTMeshoptCompression } = await load('@gltf-transform/extensions/dist/index.js');
const functions = await load('@gltf-transform/functions/dist/index.js');
const { MeshoptDecoder, MeshoptEncoder, MeshoptSimplifier } = await load('meshoptimizer/index.js');
const { PsplitMeshDracoPatches, createDecoder, decodeAhead, psplit: make_patches } = await import(pathToFileURL(path.join(package_folder, 'gltf-transform.js')));
const { createEncoder } = await import(pathToFileURL(path.join(package_folder, 'encode.js')));

const kName = 'PSPLIT_mesh_draco_patches';
const decoder = await createDecoder(), encoder = createEncoder();
after(() => encoder.dispose());
const folder = mkdtempSync(path.join(tmpdir(), 'psplit-gltf-transform-'));
after(() => rmSync(folder, { recursive: true }));
const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const sample = (name) => path.join(samples, name);

// An I/O and the warnings that it logs.
function make_io(dependencies = { 'psplit.decoder': decoder }) {
  const warnings = [], nothing = () => {};
  const io = new NodeIO().setLogger({ debug: nothing, info: nothing, error: nothing, warn: (text) => warnings.push(text) })
    .registerExtensions([...ALL_EXTENSIONS, PsplitMeshDracoPatches])
    .registerDependencies({ 'meshopt.decoder': MeshoptDecoder, 'meshopt.encoder': MeshoptEncoder, ...dependencies });
  return { io, warnings: () => warnings.filter((text) => text.includes(kName)) };
}
const primitives_of = (document) => document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives());
const first_primitive = (document) => primitives_of(document)[0];
const facts = (accessor) => accessor && [accessor.getType(), accessor.getNormalized(), accessor.getArray()];
const geometry = (document) => primitives_of(document).map((primitive) => [primitive.getMode(), facts(primitive.getIndices()),
  ...primitive.listSemantics().sort().map((name) => [name, facts(primitive.getAttribute(name))]),
  ...primitive.listTargets().map((target) => target.listSemantics().sort().map((name) => facts(target.getAttribute(name))))]);

// The containers of a file, in the order of primitives.
function containers(file) {
  const { json, view_bytes } = read_asset(file);
  return (json.meshes ?? []).flatMap(fine_primitives).map((primitive) => primitive.extensions?.[kName])
    .map((stored) => stored && Buffer.from(view_bytes(stored.bufferView)).toString('base64'));
}
async function written(io, document, name = 'out.glb') {
  const file = path.join(folder, name);
  await io.write(file, document);
  return file;
}
const native = (...arguments_) => execFileSync(gltf_psplit, arguments_, { stdio: ['ignore', 'pipe', 'pipe'] });
const needs_tool = { skip: gltf_psplit === null && 'there is no gltf-psplit' };

test('samples have the arrays of decodeContainer', async () => {
  for (const name of ['patches.glb', 'residue.glb', 'condensed.glb', 'coarse.glb', 'fallback.gltf']) {
    const { io, warnings } = make_io(), document = await io.read(sample(name));
    const [{ bytes, attributes }] = compressed_primitives(sample(name), kName), primitive = first_primitive(document);
    const mesh = await psplit.decodeContainer(bytes, { attributes });
    assert.deepEqual(Uint32Array.from(primitive.getIndices().getArray()), mesh.indices, name);
    for (const { name, array } of mesh.attributes) assert.deepEqual(primitive.getAttribute(name).getArray(), array, name);
    assert.deepEqual(warnings(), []);
  }
});

test('workers may decode ahead', async () => {
  const pool = psplit.createPool({ workers: 2 });
  try {
    const { io } = make_io({}), json = await io.readAsJSON(sample('patches.glb'));
    await assert.rejects(io.readJSON(json), { code: 'invalid-input', message: /"psplit\.decoder" is missing/ });
    await decodeAhead(json, pool);
    assert.deepEqual(geometry(await io.readJSON(json)), geometry(await make_io().io.read(sample('patches.glb'))));
    json.json.meshes[0].primitives[0].extensions[kName].attributes.POSITION = 77;
    await assert.rejects(decodeAhead(json, pool), { message: /^\[PSPLIT_mesh_draco_patches\] mesh 0, primitive 0: patch 0: .*unique id 77/ });
  } finally {
    pool.dispose();
  }
});

test('errors name mesh and primitive', async () => {
  const { io } = make_io();
  const read = async (edit) => {
    const document = await io.readAsJSON(sample('patches.glb'));
    document.json = structuredClone(document.json);
    document.resources = structuredClone(document.resources);
    edit(document.json, document.json.meshes[0].primitives[0], document.resources);
    return io.readJSON(document);
  };
  const rejects = (edit, message) => assert.rejects(read(edit), { name: 'PsplitError', code: 'invalid-input',
    message: `[${kName}] mesh 0, primitive 0: ${message}` });
  const count = first_primitive(await io.read(sample('patches.glb'))).getAttribute('POSITION').getCount();
  await rejects((json, primitive) => { json.accessors[primitive.attributes.POSITION].count += 1; },
    `the accessor of POSITION has ${count + 1} points, but the patches have ${count}`);
  await rejects((json, primitive) => { primitive.mode = 5; }, 'patches are triangle lists: mode must be 4');
  await rejects((json, primitive) => { delete primitive.indices; }, 'indices has no accessor');
  await rejects((json, primitive) => { primitive.extensions[kName].bufferView = 99; }, 'the container has no buffer view');
  await rejects((json, primitive) => { primitive.extensions[kName].attributes.TANGENT = 3; }, 'TANGENT has no accessor');
  await rejects((json, primitive) => { json.bufferViews[primitive.extensions[kName].bufferView].byteLength -= 1; },
    'container: its length is not the sum of its parts');
});

test('what did not change is written byte for byte', async () => {
  for (const name of ['patches.glb', 'residue.glb', 'condensed.glb', 'seams.glb']) {
    const { io, warnings } = make_io(), document = await io.read(sample(name));
    const file = await written(io, document);
    assert.deepEqual(containers(file), containers(sample(name)), name);
    assert.deepEqual(geometry(await io.read(file)), geometry(document), name);
    const { json } = read_asset(file);
    assert.deepEqual(json.extensionsRequired, [kName]);
    for (const accessor of json.accessors) assert.equal(accessor.bufferView, undefined);
    assert.deepEqual(warnings(), []);
  }
});

test('morph targets in patches', async () => {
  const { io, warnings } = make_io(), asset = sample('targets.glb');
  const [{ bytes, attributes }] = compressed_primitives(asset, kName), mesh = await psplit.decodeContainer(bytes, { attributes });
  const document = await io.read(asset), primitive = first_primitive(document), accessor = (t, name) => primitive.listTargets()[t].getAttribute(name);
  const targets = mesh.attributes.filter(({ name }) => name.startsWith('targets/'));
  assert.equal(targets.length, 5);
  for (const { name, array } of targets) assert.deepEqual(accessor(name.split('/')[1], name.split('/')[2]).getArray(), array, name);
  assert.deepEqual(accessor(2, 'POSITION').getArray(), new Float32Array(3 * mesh.pointCount));
  const pool = psplit.createPool({ workers: 1 }), ahead = await io.readAsJSON(asset);
  await decodeAhead(ahead, pool);
  pool.dispose();
  assert.deepEqual(geometry(await make_io({}).io.readJSON(ahead)), geometry(document));

  const stored_of = (file) => fine_primitives(read_asset(file).json.meshes[0])[0].extensions?.[kName]?.targets;
  const file = await written(io, document), before = stored_of(asset);
  assert.deepEqual([containers(file), stored_of(file)], [containers(asset), before]);
  const { json } = read_asset(file), [{ primitives: [{ targets: of_json }] }] = json.meshes;
  for (const name of Object.keys(before))
    before[name].forEach((id, t) => id >= 0 && assert.equal(json.accessors[of_json[t][name]].bufferView, undefined));
  // Targets that the container does not have: one that is new, and one that is left.
  const moved = document.createAccessor().setType('VEC3').setArray(new Float32Array(3 * mesh.pointCount).fill(0.5)).setBuffer(document.getRoot().listBuffers()[0]);
  primitive.addTarget(document.createPrimitiveTarget().setAttribute('POSITION', moved));
  primitive.listTargets()[1].setAttribute('NORMAL', null);
  const more = await written(io, document);
  assert.deepEqual(stored_of(more), { POSITION: [...before.POSITION, -1], NORMAL: [before.NORMAL[0], -1, -1, -1], TEXCOORD_0: [...before.TEXCOORD_0, -1] });
  assert.deepEqual(geometry(await io.read(more)), geometry(document));
  if (gltf_psplit !== null) native('validate', '-q', more);
  // As a fallback, accessors have the data.
  const extension = document.getRoot().listExtensionsUsed().find((of) => of.extensionName === kName).setRequired(false);
  const both = await written(io, document);
  assert.deepEqual(containers(both), containers(asset));
  assert.deepEqual(geometry(await make_io({}).io.read(both)), geometry(document));
  extension.setRequired(true);
  assert.deepEqual(warnings(), []);
  // Another order, and other deltas.
  const [first] = primitive.listTargets();
  primitive.removeTarget(first);
  const without = await written(io, document);
  assert.match(warnings()[0], /mesh 0, primitive 0: targets\/0\/POSITION changed/);
  assert.deepEqual([containers(without), geometry(await io.read(without))], [[undefined], geometry(document)]);
  const changed = await io.read(asset);
  first_primitive(changed).listTargets()[1].getAttribute('NORMAL').getArray()[0] += 1;
  assert.deepEqual(geometry(await io.read(await written(io, changed))), geometry(changed));
  assert.match(warnings()[1], /targets\/1\/NORMAL changed/);
});

// The coarse primitives of the first mesh, as a reader without the extension finds them.
const coarse_of = async (file) => {
  const { json } = read_asset(file), { extensions, ...mesh } = json.meshes[0];
  assert.ok(extensions[kName].primitives.length > 0);
  const whole = await make_io({}).io.readAsJSON(file);
  whole.json = { ...json, meshes: [mesh], extensionsUsed: [] };
  return geometry(await new NodeIO().readJSON(whole));
};
test('coarse primitives are kept', async () => {
  for (const name of ['coarse.glb', 'out.gltf']) {
    const { io, warnings } = make_io(), document = await io.read(sample('coarse.glb'));
    const file = await written(io, document, name), { json } = read_asset(file);
    assert.deepEqual(containers(file), containers(sample('coarse.glb')));
    assert.deepEqual(geometry(await io.read(file)), geometry(document));
    assert.deepEqual(await coarse_of(file), await coarse_of(sample('coarse.glb')));
    assert.equal(json.extensionsRequired, undefined);
    const [fine] = fine_primitives(json.meshes[0]);
    for (const accessor of [fine.indices, ...Object.values(fine.attributes)]) assert.equal(json.accessors[accessor].bufferView, undefined);
    assert.deepEqual(warnings(), []);
    // The JSON that was read is as it was, also if it is read again.
    const whole = await io.readAsJSON(file), before = JSON.stringify(whole.json);
    await io.readJSON(whole);
    assert.equal(JSON.stringify(whole.json), before);
  }
});

test('without a decoder, coarse primitives are read', async () => {
  const { io, warnings } = make_io({}), document = await io.read(sample('coarse.glb'));
  assert.deepEqual(geometry(document), await coarse_of(sample('coarse.glb')));
  assert.match(warnings()[0], /the fallback is read, and containers are not kept/);
  const { json } = read_asset(await written(io, document));
  assert.equal(json.meshes[0].extensions, undefined);
  assert.ok(!json.extensionsUsed?.includes(kName));
});

test('coarse primitives go with the last container of their mesh', async () => {
  const { io, warnings } = make_io(), document = await io.read(sample('coarse.glb'));
  first_primitive(document).getAttribute('POSITION').getArray()[0] += 1;
  const { json } = read_asset(await written(io, document));
  assert.equal(json.meshes[0].extensions, undefined);
  assert.match(warnings()[0], /POSITION changed/);
});

test('a fallback stays a fallback', async () => {
  const { io, warnings } = make_io(), document = await io.read(sample('fallback.gltf'));
  const file = await written(io, document, 'fallback.gltf'), { json } = read_asset(file);
  assert.deepEqual(containers(file), containers(sample('fallback.gltf')));
  assert.equal(json.extensionsRequired, undefined);
  for (const accessor of json.accessors) assert.notEqual(accessor.bufferView, undefined);
  const without = make_io({}), read = await without.io.read(file);
  assert.deepEqual(geometry(read), geometry(document));
  assert.match(without.warnings()[0], /the fallback is read, and containers are not kept/);
  assert.deepEqual(warnings(), []);
});

// Each transformation: whether the container is kept, and what the warning says otherwise.
const kTransforms = {
  'dedup': [() => [functions.dedup()], true],
  'prune that keeps attributes': [() => [functions.prune({ keepAttributes: true })], true],
  'clone': [async (document) => functions.cloneDocument(document), true],
  'more attributes': [(document) => {
    const primitive = first_primitive(document), points = primitive.getAttribute('POSITION').getCount();
    primitive.setAttribute('_ID', document.createAccessor().setType('SCALAR').setArray(new Float32Array(points)));
  }, true],
  'a plain primitive that shares accessors': [(document) => {
    const primitive = first_primitive(document), plain = primitive.clone().setExtension(kName, null);
    document.getRoot().listMeshes()[0].addPrimitive(plain);
  }, true],
  'a second mesh of the same container': [(document) => {
    document.createMesh().addPrimitive(first_primitive(document).clone());
  }, true],
  'weld of indexed geometry': [() => [functions.weld({ overwrite: false })], true],
  'weld': [() => [functions.weld({ overwrite: true })], /indices changed/],
  'one value': [(document) => { first_primitive(document).getAttribute('POSITION').getArray()[5] += 1; }, /mesh 0, primitive 0: POSITION changed/],
  'one index': [(document) => { first_primitive(document).getIndices().getArray()[5] ^= 1; }, /indices changed/],
  'quantize': [() => [functions.quantize()], /POSITION has another type/],
  'simplify': [async () => {
    await MeshoptSimplifier.ready;
    return [functions.simplify({ simplifier: MeshoptSimplifier, ratio: 0.5, error: 0.1 })];
  }, /indices changed/],
  'reorder': [async () => {
    await MeshoptEncoder.ready;
    return [functions.reorder({ encoder: MeshoptEncoder })];
  }, /indices changed/],
  'unweld': [() => [functions.unweld()], /not a list of indexed triangles/],
  'a removed attribute': [(document) => void first_primitive(document).setAttribute('NORMAL', null), true],
  'prune': [() => [functions.prune()], true],
  'all attributes removed': [(document) => {
    for (const name of first_primitive(document).listSemantics()) first_primitive(document).setAttribute(name, null);
    first_primitive(document).setAttribute('_ID', document.createAccessor().setType('SCALAR').setArray(new Float32Array(396)));
  }, /no attribute of its container/],
  'a new primitive in its place': [(document) => {
    const [mesh] = document.getRoot().listMeshes(), primitive = first_primitive(document);
    const plain = primitive.clone().setExtension(kName, null);
    mesh.removePrimitive(primitive).addPrimitive(plain);
    primitive.dispose();
  }, /1 containers that were read belong to no primitive/],
  'meshopt': [(document) => {
    document.createExtension(EXTMeshoptCompression).setRequired(true);
  }, true],
  'meshopt, and no more need of patches': [(document) => {
    document.createExtension(EXTMeshoptCompression).setRequired(true);
    document.getRoot().listExtensionsUsed().find((extension) => extension.extensionName === kName).setRequired(false);
  }, /another extension writes it/, true],
};
for (const [name, [transform, of_seams, of_coarse = of_seams]] of Object.entries(kTransforms))
  for (const [asset, expected] of [[sample('seams.glb'), of_seams], [sample('coarse.glb'), of_coarse], [sample('targets.glb'), of_seams]]) test(`${path.basename(asset)} after ${name}`, async () => {
    await Promise.all([MeshoptEncoder.ready, MeshoptDecoder.ready]);
    const { io, warnings } = make_io();
    let document = await io.read(asset);
    const result = await transform(document);
    if (result instanceof Document) document = result;
    else if (Array.isArray(result)) await document.transform(...result);
    const file = await written(io, document), again = await io.read(file);
    // Meshoptimizer's index codec may rotate triangles.
    const same = (indices) => name.startsWith('meshopt') ? Uint32Array.from(indices).sort() : indices;
    const data = (of) => geometry(of).map(([mode, indices, ...others]) => [mode, indices && [indices[0], indices[1], same(indices[2])], ...others]);
    assert.deepEqual(data(again), data(document), 'no data is lost');
    if (expected === true) {
      assert.deepEqual(warnings(), []);
      assert.deepEqual(containers(file)[0], containers(asset)[0]);
    } else {
      assert.equal(warnings().length, 1);
      assert.match(warnings()[0], expected);
      assert.deepEqual(containers(file).filter((container) => container !== undefined), []);
      assert.ok(!(read_asset(file).json.extensionsUsed ?? []).includes(kName));
    }
    if (gltf_psplit !== null && expected === true) native('validate', '-q', file);
  });

test('primitives that share accessors, but not containers, have their own arrays', async () => {
  const { io, warnings } = make_io(), document = await io.readAsJSON(sample('patches.glb'));
  const json = document.json = structuredClone(document.json), [primitive] = json.meshes[0].primitives;
  const { byteOffset = 0, byteLength } = json.bufferViews[primitive.extensions[kName].bufferView];
  const [key] = Object.keys(document.resources), glb = Buffer.from(document.resources[key]);
  // The second container is a copy in which the grids of positions begin elsewhere.
  const copy = Buffer.from(glb.subarray(byteOffset, byteOffset + byteLength));
  const origin = Buffer.from(Float32Array.from(json.accessors[primitive.attributes.POSITION].min).buffer);
  for (let at = copy.indexOf(origin); at >= 0; at = copy.indexOf(origin)) copy.writeFloatLE(copy.readFloatLE(at) + 1, at);
  document.resources[key] = Buffer.concat([glb, copy]);
  json.buffers[0].byteLength = glb.length + copy.length;
  json.bufferViews.push({ buffer: 0, byteOffset: glb.length, byteLength: copy.length });
  json.meshes[0].primitives.push({ ...primitive, extensions: { [kName]: { ...primitive.extensions[kName],
    bufferView: json.bufferViews.length - 1 } } });
  const read = await io.readJSON(document), [first, second] = primitives_of(read).map((each) => each.getAttribute('POSITION').getElement(7, []));
  assert.deepEqual(geometry(read)[0], geometry(await io.read(sample('patches.glb')))[0]);
  assert.ok(Math.abs(second[0] - first[0] - 1) < 1e-6 && second[1] === first[1], `${first} ${second}`);
  const file = await written(io, read);
  assert.equal(new Set(containers(file)).size, 2);
  assert.deepEqual(geometry(await io.read(file)), geometry(read));
  assert.deepEqual(warnings(), []);
});

// What gltf-psplit writes by default: small primitives are not split, and in KHR_draco_mesh_compression.
test('an asset that has Draco primitives as well', needs_tool, async () => {
  const [plain, mixed] = ['scene.glb', 'mixed.glb'].map((name) => path.join(folder, name));
  native('generate', '-q', plain, '--shape', 'scene', '--faces', '20000', '--normals');
  native('encode', '-q', '--patch-faces', '1000', '--min-faces', '4000', plain, mixed);
  const stored = containers(mixed), is_patched = stored.map((container) => container !== undefined);
  assert.ok(is_patched.includes(true) && is_patched.includes(false));
  const draco3d = require_module('draco3d');
  const { io, warnings } = make_io({ 'psplit.decoder': decoder, 'draco3d.decoder': await draco3d.createDecoderModule(),
    'draco3d.encoder': await draco3d.createEncoderModule() });
  const document = await io.read(mixed), file = await written(io, document), again = await io.read(file), { json } = read_asset(file);
  assert.deepEqual(containers(file), stored);
  assert.deepEqual(geometry(again).filter((_, i) => is_patched[i]), geometry(document).filter((_, i) => is_patched[i]));
  assert.deepEqual(json.extensionsRequired.toSorted(), ['KHR_draco_mesh_compression', kName]);
  const references = json.meshes.flatMap((mesh) => mesh.primitives).flatMap(({ attributes, indices }) => [...Object.values(attributes), indices]);
  assert.equal(new Set(references).size, json.accessors.length, 'all accessors are used');
  assert.deepEqual(warnings(), []);
  native('validate', '-q', file);
  // A change makes Draco's of it, and says so. A plain copy needs Draco's accessors, too.
  const changed = is_patched.indexOf(true), copied = is_patched.lastIndexOf(true);
  primitives_of(document)[changed].getAttribute('POSITION').getArray()[0] += 0.5;
  document.getRoot().listMeshes()[copied].addPrimitive(primitives_of(document)[copied].clone().setExtension(kName, null));
  const rest = containers(await written(io, document));
  assert.deepEqual([rest[changed], rest[copied]], [undefined, undefined]);
  assert.notEqual(copied, changed);
  assert.match(warnings().at(-1), /primitive 0: POSITION changed; .*primitive 0: another extension writes it\. The transform/);
  assert.equal((await io.read(path.join(folder, 'out.glb'))).getRoot().listMeshes().length, stored.length);
});

test('an asset without a decoder is written with a message', async () => {
  const document = await make_io().io.read(sample('patches.glb'));
  document.getRoot().listExtensionsUsed().find((extension) => extension.extensionName === kName).dispose();
  const { io } = make_io({}), file = await written(io, document);
  assert.deepEqual(geometry(await io.read(file)), geometry(document));
});

test('the corpus', { ...needs_tool, timeout: 600000, ...(corpus_folder === null && { skip: 'there is no corpus' }) }, async () => {
  const validate = require_module('gltf-validator').validateBytes;
  await Promise.all([MeshoptEncoder.ready, MeshoptDecoder.ready]);
  let kept = 0, count = 0;
  for (const [i, source] of files_below(path.join(corpus_folder, 'gltf'), /\.(glb|gltf)$/i).entries()) {
    const [encoded, plain] = ['encoded.glb', 'plain.glb'].map((name) => path.join(folder, name));
    for (const file of [encoded, plain]) if (existsSync(file)) rmSync(file);
    try {
      native('encode', '-q', '--always-patches', '--patch-faces', '800', ...(i % 2 === 0 ? ['--condense'] : []), source, encoded);
    } catch {
      continue;
    }
    const stored = containers(encoded).filter((container) => container !== undefined);
    if (stored.length === 0) continue;
    native('decode', '-q', encoded, plain);
    const { io, warnings } = make_io();
    let document, expected;
    try {
      expected = await io.read(plain);
    } catch {
      continue;  // glTF-Transform does not read this asset
    }
    document = await io.read(encoded);
    assert.deepEqual(geometry(document), geometry(expected), source);
    let file;
    try {
      file = await written(io, document);
    } catch (error) {
      await assert.rejects(written(io, expected, 'expected.glb'), { message: error.message }, source);
      continue;
    }
    assert.deepEqual(containers(file).filter((container) => container !== undefined), stored, source);
    assert.deepEqual(warnings(), [], source);
    assert.deepEqual(geometry(await io.read(file)), geometry(expected), source);
    native('validate', '-q', file);
    const { issues } = await validate(readFileSync(file), { maxIssues: 0 });
    const before = await validate(readFileSync(encoded), { maxIssues: 0 });
    assert.ok(issues.numErrors <= before.issues.numErrors, `${source}: ${JSON.stringify(issues.messages)}`);
    ++count;
    kept += stored.length;
  }
  assert.ok(count >= 100, `${count} assets`);
  assert.ok(kept >= count);
});

// --- psplit()

test('psplit() writes the containers of the command', needs_tool, async () => {
  const [plain, wanted] = ['plain.glb', 'wanted.glb'].map((name) => path.join(folder, name));
  native('generate', '-q', plain, '--shape', 'scene', '--faces', '30000', '--normals', '--texcoords');
  for (const [options, ...flags] of [[{}], [{ condense: true, profile: 'speed' }, '--condense', '--profile', 'speed'],
    [{ quantizationVolume: 'primitive', patches: 30, encoder }, '--quantization-volume', 'primitive', '--patches', '30'],
    [{ quantizationVolume: 'scene', boxes: true, encoder }, '--quantization-volume', 'scene', '--boxes']]) {
    native('encode', '-q', '--always-patches', ...flags, plain, wanted);
    // This works without a registered decoder, too.
    const { io, warnings } = make_io({}), document = await io.read(plain);
    await document.transform(make_patches(options));
    const file = await written(io, document), { json } = read_asset(file);
    assert.deepEqual(containers(file), containers(wanted));
    assert.deepEqual(json.extensionsRequired, [kName]);
    for (const accessor of json.accessors) assert.equal(accessor.bufferView, undefined);
    assert.deepEqual(warnings(), []);
    native('validate', '-q', file);
    assert.deepEqual(geometry(await make_io().io.read(file)), geometry(document));
    assert.deepEqual(geometry(document), geometry(await make_io().io.read(wanted)));
  }
});

test('psplit() leaves what it cannot encode, and says so', async () => {
  const { io, warnings } = make_io(), document = new Document().setLogger(io.getLogger?.() ?? io._logger), buffer = document.createBuffer();
  const positions = document.createAccessor().setType('VEC3').setArray(Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0])).setBuffer(buffer);
  const indices = (...numbers) => document.createAccessor().setArray(Uint16Array.from(numbers)).setBuffer(buffer);
  const primitive = (...numbers) => document.createPrimitive().setIndices(indices(...numbers)).setAttribute('POSITION', positions);
  const mesh = document.createMesh().addPrimitive(primitive(0, 1, 2)).addPrimitive(primitive(0, 1).setMode(1)).addPrimitive(primitive(1, 1, 2))
    .addPrimitive(primitive(2, 1, 3));
  document.createScene().addChild(document.createNode().setMesh(mesh));
  const made = primitives_of(document);
  await document.transform(make_patches());
  assert.match(warnings()[0], /left as it is: mesh 0, primitive 1: it is no list of triangles; mesh 0, primitive 2: no triangles but degenerate ones\./);
  assert.deepEqual(made.map((each) => each.getExtension(kName) !== null), [true, false, false, true]);
  assert.equal(made[1].getAttribute('POSITION'), positions);
  const file = await written(io, document);
  assert.deepEqual(geometry(await io.read(file)), geometry(document));
  await document.transform(make_patches());
  assert.match(warnings()[1], /primitive 0: it is in patches already/);
  assert.throws(() => make_patches({ quantizationVolume: 'all' }), { code: 'invalid-input' });
  await assert.rejects(document.transform(make_patches({ encoder, patches: -1 })), /patches/);
});

for (const lossless of [true, false]) test(`psplit() ${lossless ? 'reorders' : 'stores'} morph targets, and primitives share a container`, async () => {
  const document = new Document(), buffer = document.createBuffer(), size = 20, places = [], moves = [], faces = [];
  for (let y = 0; y <= size; ++y)
    for (let x = 0; x <= size; ++x) {
      places.push(x, y, Math.sin(x));
      moves.push(0, 0, x + 100 * y);
      if (x < size && y < size) faces.push(...[0, 1, size + 1, 1, size + 2, size + 1].map((k) => y * (size + 1) + x + k));
    }
  const accessor = (Type, type, numbers) => document.createAccessor().setType(type).setArray(Type.from(numbers)).setBuffer(buffer);
  const target = document.createPrimitiveTarget().setAttribute('POSITION', accessor(Float32Array, 'VEC3', moves));
  const primitive = document.createPrimitive().setIndices(accessor(Uint32Array, 'SCALAR', faces)).addTarget(target)
    .setAttribute('POSITION', accessor(Float32Array, 'VEC3', places));
  document.createMesh().addPrimitive(primitive);
  document.createMesh().addPrimitive(primitive.clone());
  await document.transform(make_patches({ patchFaces: 200, lossless }));
  const [first, second] = primitives_of(document);
  assert.equal(first.getExtension(kName), second.getExtension(kName));
  const { io } = make_io(), file = await written(io, document), read = first_primitive(await io.read(file));
  assert.equal(new Set(containers(file)).size, 1);
  assert.equal(read.getAttribute('POSITION').getCount(), (size + 1) ** 2);
  // Exact floats stay in accessors.
  assert.deepEqual(read_asset(file).json.meshes[0].primitives[0].extensions[kName].targets, lossless ? undefined : { POSITION: [1] });
  assert.deepEqual(geometry(await io.read(file)), geometry(document));
  const of_places = new Map(Array.from({ length: places.length / 3 }, (_, i) => [places.slice(3 * i, 3 * i + 2).join(), moves[3 * i + 2]]));
  const move = read.listTargets()[0].getAttribute('POSITION');
  for (let i = 0; i < move.getCount(); ++i)
    assert.ok(Math.abs(move.getElement(i, [])[2] - of_places.get(read.getAttribute('POSITION').getElement(i, []).slice(0, 2).map(Math.round).join())) < (lossless ? 1e-9 : 0.01));
  if (gltf_psplit !== null) native('validate', '-q', file);
});

test('psplit() writes the morph targets of the command', needs_tool, async () => {
  const [plain, wanted] = ['plain.glb', 'wanted.glb'].map((name) => path.join(folder, name));
  native('decode', '-q', sample('targets.glb'), plain);
  for (const [options, ...flags] of [[{}], [{ morphBits: 6, condense: true }, '--quantize-morph', '6', '--condense'],
    [{ lossless: true }, '--lossless']]) {
    native('encode', '-q', '--always-patches', ...flags, plain, wanted);
    const { io, warnings } = make_io(), document = await io.read(plain);
    await document.transform(make_patches(options));
    const file = await written(io, document), stored = (of) => read_asset(of).json.meshes[0].primitives[0].extensions[kName];
    assert.deepEqual([containers(file), stored(file).targets], [containers(wanted), stored(wanted).targets], flags.join());
    assert.deepEqual(geometry(await io.read(file)), geometry(await io.read(wanted)));
    native('validate', '-q', file);
    assert.deepEqual(warnings(), []);
  }
});

test('psplit() on the corpus: the containers of the command', { ...needs_tool, timeout: 600000, ...(corpus_folder === null && { skip: 'there is no corpus' }) }, async () => {
  let count = 0;
  for (const [i, source] of files_below(path.join(corpus_folder, 'gltf'), /\.(glb|gltf)$/i).entries()) {
    if (i % 4 !== 0 && !source.includes('Meta')) continue;
    const [plain, wanted] = ['plain.glb', 'wanted.glb'].map((name) => path.join(folder, name));
    try {
      native('encode', '-q', '--lossless', '--always-patches', source, wanted);
      native('decode', '-q', wanted, plain);
      native('encode', '-q', '--always-patches', plain, wanted);
    } catch {
      continue;
    }
    const { io } = make_io();
    let document;
    try {
      document = await io.read(plain);
      await written(io, document);
    } catch {
      continue;  // glTF-Transform does not read or write this asset
    }
    // glTF-Transform drops this extension, which tells the attributes that hold property values.
    const { propertyAttributes = [] } = read_asset(plain).json.extensions?.EXT_structural_metadata ?? {};
    const exact = propertyAttributes.flatMap(({ properties }) => Object.values(properties).map(({ attribute }) => attribute));
    await document.transform(make_patches({ encoder, exact }));
    const file = await written(io, document), theirs = containers(wanted);
    if (theirs.every((container) => container === undefined)) continue;
    assert.deepEqual(containers(file), theirs, source);
    native('validate', '-q', file);
    ++count;
  }
  assert.ok(count >= 25, `${count} assets`);
});
