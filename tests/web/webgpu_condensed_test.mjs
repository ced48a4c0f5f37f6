// psplit/webgpu: condensed patches, in Node.js on a processor.
import assert from 'node:assert/strict';
import path from 'node:path';
import test, { after, before } from 'node:test';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, gltf_psplit, make_container, package_folder, psplit, random_numbers, samples_folder } from './load.mjs';
import { add, compare, difference } from './webgpu_compare.js';
import { createGpuDecoder, request_device, skip as no_gpu } from './webgpu_device.mjs';

const { decodeContainer } = psplit, no_tool = gltf_psplit === null && 'there is no gltf-psplit', skip = no_gpu || no_tool;
const condensed_container = (faces, patch_faces, ...options) => ({ ...make_container(faces, patch_faces, '--condense', ...options), name: [faces, patch_faces, ...options].join(' ') });
const from_package = async (name) => import(pathToFileURL(path.join(package_folder, 'webgpu', name)));
let device, decoder;
if (!skip) {
  before(async () => {
    device = await request_device();
    decoder = await createGpuDecoder(device);
  });
  after(() => device.destroy());
}

// With values in order of creation, some with border parts, with all of Draco's predictions, and raw.
const kOptions = [[200, 60], [1500, 60], [200, 60, '--encode-speed', '10'], [700, 300, '--encode-speed', '3'], [2400, 1200, '--encode-speed', '0'], [400, 200, '--profile', 'size'],
  [700, 300, '--lossless'], [400, 200, '--quantize-position', '20']];
test('condensed patches are those of WebAssembly', { skip }, async () => {
  const containers = kOptions.map((options) => condensed_container(...options)), sum = await compare(decoder, decodeContainer, containers);
  assert.deepEqual(sum, { equal: containers.length, by_wasm: 0, refused: 0, differences: [], reasons: [] });
});

test('samples of the extension, and why some go through WebAssembly', { skip }, async () => {
  const whys = { condensed: undefined, 'condensed-borders': undefined, 'condensed-lossless': undefined, 'condensed-speed-0': undefined, 'condensed-deltas': /condensed morph targets/,
    'condensed-targets': undefined, 'condensed-residue': /residue/ };
  for (const [name, why] of Object.entries(whys))
    for (const { bytes, attributes } of compressed_primitives(path.join(samples_folder, `${name}.glb`), 'PSPLIT_mesh_draco_patches')) {
      const mesh = await decoder.decode(bytes, { attributes });
      assert.equal(difference(await decodeContainer(bytes, { attributes }), await mesh.read()), undefined, name);
      assert.deepEqual([mesh.way, mesh.isCondensed], [why === undefined ? 'gpu' : 'wasm', true], `${name}: ${mesh.why}`);
      if (why !== undefined) assert.match(mesh.why, why);
      mesh.destroy();
    }
});

test('the samples have what they are taken for', { skip: no_tool }, async () => {
  const { ContainerPlan } = await from_package('container_plan.js'), { condensed } = await from_package('condensed.js'), { kSchemeCreated, kSchemeRaw } = await from_package('condensed_head.js');
  const schemes = new Set(), borders = new Set();
  for (const options of kOptions) {
    const { bytes, attributes } = condensed_container(...options), { directory } = new ContainerPlan(bytes, attributes, 'float32', 1 << 25, condensed);
    borders.add(directory.tables.has_borders);
    for (const { scheme } of condensed.read_head({ bytes }, directory, 0).condensed.stored) schemes.add(scheme);
  }
  const kParallelograms = 4, kTexCoords = 5, kGeometricNormal = 6;
  for (const scheme of [kSchemeCreated, kSchemeRaw, kParallelograms, kTexCoords, kGeometricNormal]) assert.ok(schemes.has(scheme), String(scheme));
  assert.equal(borders.size, 2);
});

test('of one call, some containers are condensed; all in several windows of memory', { skip }, async () => {
  const shared = condensed_container(1500, 60), plain = make_container(1500, 60), small = await createGpuDecoder(device, { memory: 100000 });
  const list = [shared, plain, shared, { ...shared, bytes: shared.bytes.slice(0, -1) }, plain];
  const meshes = await small.decode(list.map(({ bytes }) => bytes), { attributes: list.map(({ attributes }) => attributes), as: 'float32' });
  for (const [i, mesh] of meshes.entries()) {
    if (i === 3) {
      assert.equal(mesh.code, 'invalid-input');
      continue;
    }
    assert.deepEqual([mesh.way, mesh.isCondensed], ['gpu', list[i] === shared]);
    assert.equal(difference(await decodeContainer(list[i].bytes, { attributes: list[i].attributes }), await mesh.read()), undefined);
    mesh.destroy();
  }
});

test('quantized values of condensed patches', { skip }, async () => {
  const { bytes, attributes } = condensed_container(1500, 60), expected = await decodeContainer(bytes, { attributes }), mesh = await decoder.decode(bytes, { attributes, as: 'quantized' });
  assert.equal(mesh.way, 'gpu', mesh.why);
  const [{ scale, origin, min, max }] = mesh.attributes, [{ array }] = (await mesh.read()).attributes, positions = expected.attributes[0].array;
  assert.deepEqual(Float32Array.from(array, (place, i) => Math.fround(place * scale) + origin[i % 3]), positions);
  for (const k of [0, 1, 2]) {
    const values = positions.filter((_, i) => i % 3 === k);
    assert.deepEqual([min[k], max[k]], [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))]);
  }
  mesh.destroy();
});

// Without a device.
test('condensed containers take as many words of a batch as their plans say', { skip: no_tool }, async () => {
  const { ContainerPlan } = await from_package('container_plan.js'), { condensed } = await from_package('condensed.js');
  const sizes = ({ plan, streams, attributes, walk_words, result_words, state_words }) => [plan.length, streams.length, attributes.length, walk_words, result_words, state_words];
  for (const options of kOptions) {
    const { bytes, attributes, name } = condensed_container(...options), plan = new ContainerPlan(bytes, attributes, 'float32', 1 << 25, condensed);
    const layout = new condensed.Layout(1 << 25, [plan, plan, plan]);
    for (let i = 0; i < 3; ++i) plan.place(layout, 0);
    assert.deepEqual(sizes(layout), plan.sizes.map((words) => 3 * words), name);
    // What streams take of memory is what their heads say.
    const heads = Array.from({ length: plan.stream_count }, (_, i) => ({ ...condensed.read_head({ bytes }, plan.directory, i),
      point_count: plan.directory.points[i], reference_count: plan.directory.references[i] }));
    assert.equal(layout.memory_words, layout.take(0), name);
    assert.equal(layout.memory_words, 3 * heads.reduce((sum, head) => sum + condensed.stream_words(head), 0), name);
  }
});

// As for other containers (webgpu_test.mjs).
const kMutants = Number(process.env.PSPLIT_GPU_MUTANTS ?? 400);
async function check_hostile(make, count) {
  const sum = {};
  for (let first = 0; first < count; first += 50)
    add(sum, await compare(decoder, decodeContainer, Array.from({ length: Math.min(50, count - first) }, (_, i) => make(first + i))));
  assert.deepEqual(sum.differences, []);
  return sum;
}
test('mutants have the verdict of the CPU', { skip }, async (t) => {
  const samples = [condensed_container(200, 60), condensed_container(600, 60), condensed_container(200, 60, '--encode-speed', '0'), condensed_container(200, 60, '--lossless'),
    condensed_container(200, 60, '--profile', 'size')], random = random_numbers(5);
  const sum = await check_hostile((i) => {
    const { bytes, attributes } = samples[i % samples.length], mutant = bytes.slice(), view = new DataView(bytes.buffer, bytes.byteOffset);
    // Of tables, nearly any change breaks all: three of four mutants are of streams.
    const streams = 20 + view.getUint32(12, true) + view.getUint32(16, true);
    for (let n = 1 + random(3); n > 0; --n) mutant[random(4) === 0 ? random(bytes.length) : streams + random(bytes.length - streams)] ^= 1 << random(8);
    return { name: `mutant ${i}`, bytes: mutant, attributes };
  }, kMutants);
  t.diagnostic(JSON.stringify({ ...sum, reasons: undefined, differences: undefined }));
  assert.ok(sum.refused > kMutants / 4);
});
test('mutants of skeletons', { skip }, async (t) => {
  const { bytes, attributes } = condensed_container(200, 60), random = random_numbers(6), view = new DataView(bytes.buffer, bytes.byteOffset), head = 20 + view.getUint32(12, true);
  const sum = await check_hostile((i) => {
    const mutant = bytes.slice();
    mutant[head + random(100)] ^= 1 << random(8);
    return { name: `skeleton ${i}`, bytes: mutant, attributes };
  }, kMutants / 4);
  t.diagnostic(JSON.stringify({ ...sum, reasons: undefined, differences: undefined }));
  assert.ok(sum.refused > 0 && sum.equal > 0, JSON.stringify(sum));
});
test('condensed containers that end early, or in zeros', { skip }, async () => {
  const { bytes, attributes } = condensed_container(60, 30), step = Math.ceil((2 * bytes.length) / kMutants), count = Math.floor(bytes.length / step);
  const ended = await check_hostile((i) => ({ name: `${step * i} bytes`, bytes: bytes.slice(0, step * i), attributes }), count);
  assert.equal(ended.refused, count);
  await check_hostile((i) => ({ name: `${step * i} bytes and zeros`, bytes: bytes.slice().fill(0, step * i), attributes }), count);
});

test('a device that is lost while the shaders are compiled', { skip }, async () => {
  const { bytes, attributes } = condensed_container(200, 60);
  for (const fallback of [undefined, 'wasm']) {
    const other = await request_device(), of_other = await createGpuDecoder(other, { fallback }), decoding = of_other.decode(bytes, { attributes });
    other.destroy();
    if (fallback === undefined) await assert.rejects(decoding, { code: 'failed', message: /lost/ });
    else assert.equal((await decoding).way, 'wasm');
  }
});

test('the device decodes as before', { skip }, async () => {
  const sum = await compare(decoder, decodeContainer, [condensed_container(400, 200)]);
  assert.equal(sum.equal, 1);
});
