// PsplitPlugin and PsplitDracoLoader in three's loaders.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import test, { after } from 'node:test';
import { BlobWorker } from './blob_worker.mjs';
import { geometries_of, geometry_differences, values_of } from './compare_scenes.mjs';
import { corpus_folder, modules_folder, psplit, read_asset, root } from './load.mjs';
import { draco_glb, streams } from './stock_draco.mjs';
import { buffer_of, GLTFLoader, make_loader, PsplitDracoLoader, PsplitPlugin, THREE } from './three_loaders.mjs';

const kExtension = 'PSPLIT_mesh_draco_patches';
const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const expected = JSON.parse(readFileSync(path.join(samples, 'expected.json')));
const hash = (array) => createHash('sha256').update(new Uint8Array(array.buffer, array.byteOffset, array.byteLength)).digest('hex');
const data_uri = (bytes) => `data:application/octet-stream;base64,${Buffer.from(bytes).toString('base64')}`;

const pool = psplit.createPool({ workers: 2 });
after(() => pool.dispose());

// The JSON of a sample, with buffers in it. `add(bytes)` adds a buffer view.
function sample(name) {
  const { json, view_bytes } = read_asset(path.join(samples, name));
  const views = json.bufferViews.map((_, i) => Uint8Array.from(view_bytes(i)));
  json.buffers = views.map((bytes) => ({ uri: data_uri(bytes), byteLength: bytes.length }));
  json.bufferViews = views.map((bytes, buffer) => ({ buffer, byteLength: bytes.length }));
  const add = (bytes) => {
    json.buffers.push({ uri: data_uri(bytes), byteLength: bytes.length });
    return json.bufferViews.push({ buffer: json.buffers.length - 1, byteLength: bytes.length }) - 1;
  };
  return { json, add, container: views[0], primitive: json.meshes[0].primitives[0] };
}
const parse = (json, options = {}, loader = {}) => make_loader({ plugin: { pool, ...options }, ...loader }).parseAsync(JSON.stringify(json), '');
const geometry_of = async (gltf) => (await geometries_of(gltf)).get('mesh 0, primitive 0');
// A pool that counts what is decoded, or rejects.
const counting = (fail) => {
  const counted = { count: 0 };
  for (const name of ['decodeContainer', 'decodePatches'])
    counted[name] = async (...args) => {
      ++counted.count;
      if (fail !== undefined) throw fail;
      return pool[name](...args);
    };
  return counted;
};

function assert_sample(name, geometry) {
  const [{ points, indices_sha256, attributes_sha256, targets_sha256 = {} }] = expected[name].primitives;
  const names = { POSITION: 'position', NORMAL: 'normal', TEXCOORD_0: 'uv', _PART: '_part' };
  assert.equal(geometry.attributes.position.count, points);
  assert.equal(hash(Uint32Array.from(geometry.index.array)), indices_sha256);
  for (const [attribute, digest] of Object.entries(attributes_sha256))
    assert.equal(hash(values_of(geometry.attributes[names[attribute]])), digest, attribute);
  for (const [target, digest] of Object.entries(targets_sha256)) {
    const [, t, attribute] = target.split('/');
    // three has no targets of texture coordinates.
    if (attribute !== 'TEXCOORD_0') assert.equal(hash(values_of(geometry.morphAttributes[names[attribute]][t])), digest, target);
  }
}

test('samples', async () => {
  for (const name of Object.keys(expected)) {
    const gltf = await parse(sample(name).json), geometry = await geometry_of(gltf);
    assert_sample(name, geometry);
    assert.ok(geometry.index.array instanceof Uint16Array);
    assert.ok(geometry.boundingSphere.radius > 0);
    let mesh;
    gltf.scene.traverse((object) => (mesh = object.isMesh ? object : mesh));
    const { bytes, patchCount, faceCount } = gltf.psplit.patchesOf(mesh);
    assert.ok(bytes > 0 && patchCount > 0 && faceCount === geometry.index.count / 3);
    assert.equal(gltf.psplit.patchesOf(gltf.scene), null);
    await gltf.psplit.whole;
  }
});

test('coarse primitives are for loaders without the plugin', async () => {
  const { json } = sample('coarse.glb'), [{ primitives: [coarse], extensions }] = json.meshes;
  const stock = await geometry_of(await make_loader().parseAsync(JSON.stringify(json), ''));
  assert.equal(stock.index.count, json.accessors[coarse.indices].count);
  assert.ok(stock.index.count < json.accessors[extensions[kExtension].primitives[0].indices].count / 2);
  assert_sample('coarse.glb', await geometry_of(await parse(json)));
  for (const broken of [null, 0, {}, { primitives: 7 }, { primitives: [] }]) {
    extensions[kExtension] = broken;
    await assert.rejects(parse(json), { code: 'invalid-input', message: /mesh 0: PSPLIT_mesh_draco_patches of a mesh has no list of primitives/ });
  }
});

test('a pool of the plugin', async () => {
  const loader = new GLTFLoader().register((parser) => new PsplitPlugin(parser));
  assert_sample('patches.glb', await geometry_of(await loader.parseAsync(buffer_of(readFileSync(path.join(samples, 'patches.glb'))), '')));
});

test('equal primitives are decoded once', async () => {
  const { json, primitive } = sample('seams.glb'), counted = counting();
  primitive.material = 0;
  json.materials = [{}, {}];
  json.meshes[0].primitives.push({ ...structuredClone(primitive), material: 1 });
  json.meshes.push({ primitives: [structuredClone(primitive)] });
  json.nodes.push({ mesh: 0 }, { mesh: 1 });
  json.scenes[0].nodes.push(json.nodes.length - 2, json.nodes.length - 1);
  const geometries = new Set((await geometries_of(await parse(json, { pool: counted }))).values());
  assert.equal(counted.count, 1);
  assert.equal(geometries.size, 1);
  assert_sample('seams.glb', [...geometries][0]);
});

test('primitives that share accessors, but not containers', async () => {
  const { json, primitive, add, container } = sample('seams.glb'), counted = counting();
  const other = structuredClone(primitive);
  other.extensions[kExtension].bufferView = add(container);
  json.meshes[0].primitives.push(other);
  const geometries = [...(await geometries_of(await parse(json, { pool: counted }))).values()];
  assert.equal(counted.count, 2);
  assert.notEqual(geometries[0], geometries[1]);
  for (const geometry of geometries) assert_sample('seams.glb', geometry);
});

test('JSON that is parsed twice', async () => {
  for (const name of ['seams.glb', 'fallback.gltf']) {
    const { json } = sample(name), plain = structuredClone(json);
    for (let round = 0; round < 3; ++round)
      assert_sample(name, await geometry_of(await make_loader({ plugin: { pool } }).parseAsync(json, '')));
    if (name === 'fallback.gltf')  // the fallback is still there
      assert.deepEqual(json.accessors.slice(0, plain.accessors.length), plain.accessors);
  }
});

test('other attributes, morph targets and extras', async () => {
  const { json, add, primitive } = sample('patches.glb'), { points } = expected['patches.glb'].primitives[0];
  const accessor = (array, type) => json.accessors.push({ bufferView: add(new Uint8Array(array.buffer)), componentType: 5126, count: points,
    type, min: [0, 0, 0], max: [1, 1, 1] }) - 1;
  const floats = (components, factor) => Float32Array.from({ length: points * components }, (_, i) => Math.sin(i * factor));
  const uv = floats(2, 0.3), target = floats(3, 0.7);
  primitive.attributes.TEXCOORD_1 = accessor(uv, 'VEC2');
  primitive.targets = [{ POSITION: accessor(target, 'VEC3') }];
  primitive.extras = { made: 'here' };
  json.meshes[0].weights = [0.5];
  const gltf = await parse(json), geometry = await geometry_of(gltf);
  assert_sample('patches.glb', geometry);
  assert.deepEqual(geometry.attributes.uv1.array, uv);
  assert.deepEqual(geometry.morphAttributes.position[0].array, target);
  assert.deepEqual(geometry.userData, { made: 'here' });
  let mesh;
  gltf.scene.traverse((object) => (mesh = object.isMesh ? object : mesh));
  assert.deepEqual(mesh.morphTargetInfluences, [0.5]);
  assert.equal(mesh.userData.gltfExtensions, undefined);
});

test('morph targets in patches', async () => {
  for (const name of ['targets.glb', 'condensed-targets.glb'])
    for (const patchByPatch of [false, true]) {
      const { json } = sample(name), parts = [], [{ primitives: [primitive] }] = json.meshes;
      json.meshes[0].weights = [0.25, 0, 0.5];
      json.meshes.push({ primitives: [{ ...structuredClone(primitive), targets: [{}, primitive.targets[0], {}],
        extensions: { [kExtension]: { ...primitive.extensions[kExtension], targets: { POSITION: [-1, 3, -1], NORMAL: [-1, 4, -1] } } } }] });
      json.nodes.push({ mesh: 1 });
      json.scenes[0].nodes.push(1);
      const gltf = await parse(json, { patchByPatch, onPart: (part) => parts.push(part) });
      await gltf.psplit.whole;
      const geometries = await geometries_of(gltf), geometry = geometries.get('mesh 0, primitive 0'), other = geometries.get('mesh 1, primitive 0');
      assert_sample(name, geometry);
      const { morphAttributes: { position, normal, uv }, morphTargetsRelative } = geometry;
      assert.deepEqual([position.length, normal.length, uv, morphTargetsRelative], [3, 3, undefined, true]);
      assert.ok(position[2].array.every((value) => value === 0));  // a target without data
      let mesh;
      gltf.scene.traverse((object) => (mesh ??= object.isMesh ? object : undefined));
      assert.deepEqual(mesh.morphTargetInfluences, [0.25, 0, 0.5]);
      assert.deepEqual(parts, []);  // such a mesh comes whole
      // Another primitive with the container has targets of its own.
      assert.deepEqual([other.index.array, other.attributes.position.array], [geometry.index.array, geometry.attributes.position.array]);
      assert.deepEqual(other.morphAttributes.position[1].array, position[0].array);
      assert.deepEqual(other.morphAttributes.normal[1].array, normal[0].array);
    }
});

test('targets that break the rules', async () => {
  const cases = [
    [({ ids }) => ids.POSITION.pop(), /has no id for each target of POSITION/],
    [({ ids }) => (ids.POSITION = 3), /has no id for each target of POSITION/],
    [({ primitive }) => delete primitive.targets, /has no id for each target of POSITION/],
    [({ ids }) => (ids.TANGENT = [9, -1, -1]), /targets\/0\/TANGENT has no accessor/],
    [({ ids }) => (ids.POSITION[0] = 99), /no attribute for targets\/0\/POSITION \(unique id 99\)/],
    [({ ids }) => (ids.POSITION[0] = -2), /targets\/0\/POSITION: no unique id/],
    [({ accessor }) => (accessor.sparse = {}), /targets\/0\/POSITION is in the patches, but its accessor is sparse/],
    [({ accessor }) => ++accessor.count, /the accessor of targets\/0\/POSITION has 127 points, but the patches have 126/],
    [({ accessor }) => (accessor.type = 'VEC9'), /the accessor of targets\/0\/POSITION has no valid type/],
  ];
  for (const [edit, message] of cases) {
    const { json, primitive } = sample('targets.glb');
    edit({ primitive, ids: primitive.extensions[kExtension].targets, accessor: json.accessors[primitive.targets[0].POSITION] });
    await assert.rejects(parse(json), { code: 'invalid-input', message }, String(message));
  }
});

test('the fallback is read if a container cannot be decoded', async () => {
  const { json, container } = sample('fallback.gltf');
  for (const code of ['failed', 'unsupported', 'out-of-memory'])
    for (const patchByPatch of [false, true]) {
      const counted = counting(new psplit.PsplitError('for the test', code));
      const gltf = await parse(json, { pool: counted, patchByPatch });
      assert.equal(counted.count, 1);
      assert_sample('fallback.gltf', await geometry_of(gltf));
      await gltf.psplit.whole;
    }
  const unreachable = structuredClone(json);
  unreachable.buffers[0].uri = 'http://127.0.0.1:1/container.bin';
  assert_sample('fallback.gltf', await geometry_of(await parse(unreachable)));
  const mistake = () => { throw new RangeError('in a callback'); };
  await assert.rejects(parse(json, { onProgress: mistake }), { message: /in a callback/, mesh: 0 });
  json.buffers[0].uri = data_uri(container.fill(0xff, 40));
  await assert.rejects(parse(json), { code: 'invalid-input' });  // an invalid container is an error of the asset
});

test('errors have the place and the cause', async () => {
  const { json, container } = sample('patches.glb');
  const broken = Uint8Array.from(container).fill(0xff, container.length - 60);
  json.buffers[0].uri = data_uri(broken);
  json.meshes[0].name = 'hull';
  const error = await parse(json, { file: 'ship.glb' }).catch((reason) => reason);
  assert.ok(error instanceof psplit.PsplitError);
  assert.deepEqual([error.code, error.mesh, error.primitive], ['invalid-input', 0, 0]);
  assert.ok(error.patch > 0);
  assert.match(error.message, new RegExp(`^ship\\.glb: mesh 0 "hull", primitive 0: patch ${error.patch}: Draco stream: `));
  assert.equal(error.cause.patch, error.patch);
  json.buffers[0].uri = 'http://127.0.0.1:1/hull.bin';
  await assert.rejects(make_loader({ plugin: { pool } }).parseAsync(JSON.stringify(json), 'assets/'),
    { code: 'failed', message: /^assets\/http:\/\/127.0.0.1:1\/hull.bin: mesh 0 "hull", primitive 0: .*buffer/ });
});

test('primitives that break the rules', async () => {
  const cases = [
    [({ primitive }) => (primitive.mode = 5), /primitive 0: patches are triangle lists: mode must be 4/],
    [({ primitive }) => (primitive.extensions.KHR_draco_mesh_compression = { bufferView: 0, attributes: {} }), /KHR_draco_mesh_compression as well/],
    [({ primitive }) => (primitive.extensions[kExtension].bufferView = 9), /the container has no buffer view/],
    [({ primitive }) => (primitive.extensions[kExtension].attributes = {}), /has no attributes/],
    [({ primitive }) => (primitive.extensions[kExtension].attributes.NORMAL = 1), /NORMAL has no accessor/],
    [({ primitive }) => delete primitive.indices, /indices has no accessor/],
    [({ json }) => (json.accessors[0].sparse = {}), /its accessor is sparse/],
    [({ json }) => (json.accessors[1].componentType = 5126), /the accessor of indices has no valid type/],
    [({ json }) => (json.accessors[1].componentType = 5121), /663 points do not fit the component type 5121 of indices/],
    [({ json }) => (json.accessors[0].type = 'VEC9'), /the accessor of POSITION has no valid type/],
    [({ json }) => ++json.accessors[0].count, /the accessor of POSITION has 664 points, but the patches have 663/],
    [({ json }) => (json.accessors[1].count -= 3), /the accessor of indices has 3663 indices, but the patches have 3666/],
    [({ primitive }) => (primitive.extensions[kExtension].attributes.POSITION = 7), /no attribute for POSITION \(unique id 7\)/],
  ];
  for (const [edit, message] of cases) {
    const asset = sample('patches.glb');
    edit(asset);
    await assert.rejects(parse(asset.json, {}, { draco: new PsplitDracoLoader({ pool }) }), { code: 'invalid-input', message }, String(message));
  }
});

// A pool whose decodePatches cuts the mesh into parts, which come in another order, and first without the faces that have
// points of parts that have not come.
const scrambled = (part_count, fail_at = Infinity) => ({
  decodePatches: async (bytes, { onPart, onProgress, ...options }) => {
    const mesh = await pool.decodeContainer(bytes, options), present = new Set(), parts = [];
    const bound = (i) => Math.round((mesh.faceCount * i) / part_count);
    for (let i = 0, first_point = 0; i < part_count; ++i) {
      const indices = mesh.indices.slice(3 * bound(i), 3 * bound(i + 1));
      const end = i === part_count - 1 ? mesh.pointCount : indices.reduce((most, point) => Math.max(most, point + 1), first_point);
      parts.push({ patches: [i, i + 1], firstFace: bound(i), indices, firstPoint: first_point, pointCount: end - first_point,
        attributes: mesh.attributes.map((attribute) => ({ ...attribute,
          array: attribute.array.slice(first_point * attribute.componentCount, end * attribute.componentCount) })) });
      first_point = end;
    }
    for (const [i, at] of parts.map((_, k) => (k * 3 + 1) % part_count).entries()) {
      if (i === fail_at) throw new psplit.PsplitError('for the test', 'invalid-input', at);
      const { firstPoint, pointCount, indices } = parts[at];
      for (let point = firstPoint; point < firstPoint + pointCount; ++point) present.add(point);
      const has_come = (face) => indices.subarray(3 * face, 3 * face + 3).every((point) => present.has(point));
      onPart({ ...parts[at], isFinal: false, indices: indices.map((point, k) => (has_come(Math.floor(k / 3)) ? point : 0)) }, mesh);
      onProgress(i + 1, part_count);
      await new Promise((resolve) => setTimeout(resolve, 1));
    }
    for (const part of parts) onPart({ ...part, isFinal: true }, mesh);
    return mesh;
  },
});

test('patch by patch', async () => {
  for (const name of ['patches.glb', 'seams.glb', 'residue.glb', 'fallback.gltf'])
    for (const part_count of [null, 1, 2, 10]) {
      const steps = [];
      let geometry = null;
      const onProgress = () => {
        if (geometry === null) return;
        const index = geometry.index.array, positions = geometry.attributes.position.array;
        const drawn = Array.from({ length: index.length / 3 }, (_, i) => index.subarray(3 * i, 3 * i + 3)).filter((face) => face.some((point) => point > 0));
        steps.push(drawn.length);
        // Drawn triangles have their points: no position of these samples is 0 0 0.
        for (const point of new Set(drawn.flatMap((face) => [...face])))
          assert.ok(positions.subarray(3 * point, 3 * point + 3).some((value) => value !== 0));
      };
      const gltf = await parse(sample(name).json, { pool: part_count === null ? pool : scrambled(part_count), patchByPatch: true, onProgress });
      geometry = await geometry_of(gltf);
      await gltf.psplit.whole;
      assert_sample(name, geometry);
      if (part_count !== 10) continue;
      assert.ok(new Set(steps).size > 2, `${steps}`);
      assert.ok(geometry.index.version > 1 && geometry.index.updateRanges.length > 1 && geometry.attributes.position.version > 1);
    }
});

test('no part of a mesh is left if a patch fails', async () => {
  const { json } = sample('patches.glb');
  const gltf = await parse(json, { pool: scrambled(10, 6), patchByPatch: true }), { index } = await geometry_of(gltf);
  await assert.rejects(gltf.psplit.whole, { code: 'invalid-input', mesh: 0, primitive: 0 });
  assert.ok(index.array.every((point) => point === 0));
  await assert.rejects(parse(json, { pool: scrambled(10, 0), patchByPatch: true }), { code: 'invalid-input', mesh: 0 });
});

test('patch by patch, accessors are checked', async () => {
  const cases = [[(accessors) => (accessors[0].count = 1e9), /has 1000000000 points, but the patches have 663/],
    [(accessors) => (accessors[1].count = 30), /has 30 indices, but the patches have 3666/]];
  for (const [edit, message] of cases) {
    const { json } = sample('patches.glb');
    edit(json.accessors);
    await assert.rejects(parse(json, { patchByPatch: true }), { code: 'invalid-input', message });
  }
});

test('parts have the faces of their patches', async () => {
  const parts = [];
  const gltf = await parse(sample('patches.glb').json, { patchByPatch: true, onPart: (part, use) => parts.push({ ...part, use }) });
  await gltf.psplit.whole;
  let mesh;
  gltf.scene.traverse((object) => (mesh = object.isMesh ? object : mesh));
  const { firstFaces } = gltf.psplit.patchesOf(mesh), final = parts.filter(({ isFinal }) => isFinal);
  assert.equal(firstFaces.length, 6);
  for (const { patches: [first, end], firstFace, firstFaces: of_part, use } of final) {
    assert.deepEqual([...of_part], [...firstFaces.subarray(first, end + 1)]);
    assert.equal(of_part[0], firstFace);
    assert.deepEqual(use, { mesh: 0, primitive: 0 });
  }
  assert.equal(final.reduce((sum, { patches: [first, end] }) => sum + end - first, 0), 5);
});

test('progress', async () => {
  const { json } = sample('patches.glb'), manager = new THREE.LoadingManager(), items = [], calls = [];
  manager.onStart = (item) => items.push(item);
  const loaded = new Promise((resolve) => (manager.onLoad = resolve));
  await parse(json, { onProgress: (done, total, primitive) => calls.push([done, total, primitive]) }, { manager });
  await loaded;
  assert.ok(items.length > 0);
  const [last] = calls.slice(-1), [, total] = last;
  assert.deepEqual(last, [5, 5, { mesh: 0, primitive: 0 }]);
  assert.equal(total, 5);
});

test('abort', async () => {
  const aborted = { name: 'PsplitError', code: 'aborted', mesh: 0, primitive: 0 };
  const { json } = sample('patches.glb'), controller = new AbortController(), manager = new THREE.LoadingManager();
  await assert.rejects(parse(json, { signal: AbortSignal.abort() }), aborted);
  // While it is decoded.
  const with_abort = (abort) => ({ decodeContainer: (...args) => { const job = pool.decodeContainer(...args); abort(); return job; } });
  await assert.rejects(parse(json, { pool: with_abort(() => controller.abort()), signal: controller.signal }), aborted);
  await assert.rejects(parse(json, { pool: with_abort(() => manager.abort()) }, { manager }), aborted);
  // Also while the container is fetched.
  const server = createServer(() => {});
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const late = new AbortController();
  json.buffers[0].uri = `http://127.0.0.1:${server.address().port}/never`;
  const fetching = assert.rejects(parse(json, { signal: late.signal }), aborted);
  setTimeout(() => late.abort(), 50);
  await fetching;
  server.closeAllConnections();
  server.close();
});

// DRACOLoader, on three's own decoder.
async function with_draco_loader(use) {
  const folder = path.join(modules_folder, 'node_modules/three/examples/jsm/libs/draco');
  const server = createServer((request, response) => response.end(readFileSync(path.join(folder, path.basename(request.url)))));
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  globalThis.Worker = BlobWorker;
  const { DRACOLoader } = await import(path.join(modules_folder, 'node_modules/three/examples/jsm/loaders/DRACOLoader.js'));
  const loader = new DRACOLoader().setDecoderPath(`http://127.0.0.1:${server.address().port}/`).setWorkerLimit(1);
  try {
    await use(loader);
  } finally {
    loader.dispose();
    server.close();
  }
}
const parse_draco = (loader, bytes) => new Promise((resolve, reject) => loader.parse(Uint8Array.from(bytes).buffer, resolve, reject));

test("PsplitDracoLoader makes DRACOLoader's geometries", () => with_draco_loader(async (theirs) => {
  const ours = new PsplitDracoLoader({ pool });
  for (const [name, bytes] of streams())
    assert.deepEqual(geometry_differences(await parse_draco(theirs, bytes), await parse_draco(ours, bytes)), [], name);
  // Types that glTF asks for, by unique ids.
  const [, bytes] = [...streams()].find(([name]) => name.includes('more attributes'));
  const task = { attributeIDs: { position: 0, uv: 2, color: 3, _generic: 4 }, useUniqueIDs: true, vertexColorSpace: 'srgb-linear',
    attributeTypes: { position: 'Float32Array', uv: 'Float32Array', color: 'Uint8Array', _generic: 'Uint16Array' } };
  assert.deepEqual(geometry_differences(await theirs.decodeGeometry(Uint8Array.from(bytes).buffer, task),
    await ours.decodeGeometry(Uint8Array.from(bytes).buffer, task)), []);
}));

test('the fallback of PsplitDracoLoader', { skip: corpus_folder === null && 'there is no corpus' }, () => with_draco_loader(async (theirs) => {
  const older = readFileSync(path.join(corpus_folder, 'mesh/draco/cube_att.drc')), cloud = readFileSync(path.join(corpus_folder, 'mesh/draco/pc_color.drc'));
  for (const bytes of [older, cloud]) {
    await assert.rejects(parse_draco(new PsplitDracoLoader({ pool }), bytes), { code: 'unsupported' });
    assert.deepEqual(geometry_differences(await parse_draco(theirs, bytes), await parse_draco(new PsplitDracoLoader({ pool, fallback: theirs }), bytes)), []);
  }
}));

test('PsplitDracoLoader loads files, and owns a pool if it has none', async () => {
  const [, bytes] = [...streams()][0];
  const server = createServer((request, response) => (request.url === '/mesh.drc' ? response.end(bytes) : response.writeHead(404).end()));
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const url = (name) => `http://127.0.0.1:${server.address().port}/${name}`, manager = new THREE.LoadingManager();
  const loader = new PsplitDracoLoader(manager).setDecoderPath('/nowhere/').setDecoderConfig({ type: 'js' }).setWorkerLimit(1).preload();
  assert.equal(loader.manager, manager);
  const geometries = await Promise.all([loader.loadAsync(url('mesh.drc')), loader.loadAsync(url('mesh.drc'))]);
  assert.deepEqual(geometry_differences(...geometries), []);
  assert.equal(loader.pool.workerCount, 1);
  await assert.rejects(loader.loadAsync(url('none.drc')));
  await assert.rejects(parse_draco(loader, new Uint8Array(20)), { code: 'invalid-input' });
  const { pool: own } = loader;
  assert.equal(loader.dispose(), loader);
  assert.equal(own.workerCount, 0);
  assert.ok((await loader.loadAsync(url('mesh.drc'))).index.count > 0);  // with a new pool
  loader.dispose();
  new PsplitDracoLoader({ pool }).dispose();
  await pool.ready();
  server.close();
});

const [[, stream]] = [...streams()], draco_file = buffer_of(draco_glb(stream));
const index_counts = ({ scene }) => {
  const counts = [];
  scene.traverse((object) => object.isMesh && counts.push(object.geometry.index.count));
  return counts;
};
test('the plugin decodes stock Draco, or a DRACOLoader that it is given', async () => {
  const { faceCount } = await psplit.decodeDraco(stream);
  assert.deepEqual(index_counts(await make_loader({ plugin: { pool } }).parseAsync(draco_file, '')), [3 * faceCount]);
  // In the loader's stead, if it has one.
  const unused = { preload() {}, decodeDracoFile: () => assert.fail('it is used') };
  assert.deepEqual(index_counts(await make_loader({ draco: unused, plugin: { pool } }).parseAsync(draco_file, '')), [3 * faceCount]);
  const given = { preload() {}, decodeDracoFile: (buffer, resolve, ids, types) => {
    assert.deepEqual([buffer.byteLength, ids, types], [stream.length, { position: 0 }, { position: 'Float32Array' }]);
    resolve(new THREE.BufferGeometry().setIndex([0, 1, 2]));
  } };
  assert.deepEqual(index_counts(await make_loader({ plugin: { pool, dracoLoader: given } }).parseAsync(draco_file, '')), [3]);
  assert.deepEqual(index_counts(await make_loader({ draco: given, plugin: { pool, dracoLoader: false } }).parseAsync(draco_file, '')), [3]);
  await assert.rejects(make_loader({ plugin: { pool, dracoLoader: false } }).parseAsync(draco_file, ''), /No DRACOLoader instance/);
  const broken = buffer_of(draco_glb(stream));
  new Uint8Array(broken)[Buffer.from(broken).indexOf('DRACO\x02')] = 0;
  await assert.rejects(make_loader({ plugin: { pool, file: 'ship.glb' } }).parseAsync(broken, ''), { mesh: 0, primitive: 0, message: /^ship\.glb: mesh 0, primitive 0: / });
});

test('without the plugin, three warns of the extension, and its meshes are nothing', async () => {
  const { warn } = console, lines = [];
  console.warn = (...line) => lines.push(line.join(' '));
  try {
    const { scene } = await make_loader().parseAsync(buffer_of(readFileSync(path.join(samples, 'patches.glb'))), '');
    scene.traverse(({ geometry }) => geometry && assert.ok([geometry.index, geometry.attributes.position].every(({ array }) => array.every((value) => value === 0))));
  } finally {
    console.warn = warn;
  }
  assert.ok(lines.some((line) => line.includes('Unknown extension "PSPLIT_mesh_draco_patches"')), `${lines}`);
});

test('meshes and their materials are made in the order of the file', async () => {
  const { json, primitive } = sample('patches.glb'), indices = json.accessors[primitive.indices];
  // The last mesh is decoded first. Without tangents, three copies a material when it makes a mesh.
  json.materials = [0, 1, 2].map((i) => ({ name: `of ${i}` }));
  json.accessors.push({ ...indices }, { ...indices });
  json.meshes = [0, 1, 2].map((i) => ({ name: `mesh ${i}`, primitives: [{ ...structuredClone(primitive), material: i,
    indices: i === 0 ? primitive.indices : json.accessors.length - i }] }));
  json.nodes = [0, 1, 2].map((mesh) => ({ mesh }));
  json.scenes = [{ nodes: [0, 1, 2] }];
  json.scene = 0;
  const finished = [];
  let count = 0;
  const slow = { decodeContainer: async (...args) => {
    const place = count++, mesh = await pool.decodeContainer(...args);
    await new Promise((resolve) => setTimeout(resolve, 100 * (2 - place)));
    finished.push(place);
    return mesh;
  } };
  const loader = new GLTFLoader();
  loader.register((parser) => new PsplitPlugin(parser, { pool: slow }));
  const { scene } = await loader.parseAsync(JSON.stringify(json), ''), materials = [];
  scene.traverse((object) => object.isMesh && materials.push(object.material));
  assert.deepEqual(finished, [2, 1, 0]);
  assert.equal(materials.length, 3);
  assert.ok(materials[0].id < materials[1].id && materials[1].id < materials[2].id, materials.map(({ id }) => id).join());
});
