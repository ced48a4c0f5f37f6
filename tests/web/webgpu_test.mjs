// psplit/webgpu in Node.js, on a processor: results, ways, errors, and hostile containers.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after, before } from 'node:test';
import { setTimeout as wait } from 'node:timers/promises';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, gltf_psplit, make_container, package_folder, psplit, random_numbers, samples_folder } from './load.mjs';
import { add, are_equal, compare, difference } from './webgpu_compare.js';
import { createGpuDecoder, request_device, skip as no_gpu } from './webgpu_device.mjs';

const { decodeContainer } = psplit;
const skip = no_gpu || (gltf_psplit === null && 'there is no gltf-psplit');
let device, decoder;
// SwiftShader takes a while to compile the shaders.
if (!skip) {
  before(async () => {
    device = await request_device();
    decoder = await createGpuDecoder(device);
  });
  after(() => device.destroy());
}

const by_gpu = async (bytes, options, as) => {
  const mesh = await decoder.decode(bytes, { ...options, as });
  assert.equal(mesh.way, 'gpu', mesh.why);
  return mesh;
};

test('patches with seams, normals and references are those of WebAssembly', { skip }, async () => {
  const { bytes, attributes } = make_container(1500, 300), expected = await decodeContainer(bytes, { attributes });
  const mesh = await by_gpu(bytes, { attributes });
  assert.equal(difference(expected, await mesh.read()), undefined);
  assert.deepEqual([mesh.faceCount, mesh.pointCount, mesh.indices.count], [expected.faceCount, expected.pointCount, expected.indices.length]);
  const [positions] = mesh.attributes, { array } = expected.attributes[0];
  for (const k of [0, 1, 2]) {
    const values = array.filter((_, i) => i % 3 === k);
    assert.equal(positions.min[k], values.reduce((a, b) => Math.min(a, b)));
    assert.equal(positions.max[k], values.reduce((a, b) => Math.max(a, b)));
  }
  mesh.destroy();
});

test('all predictions and walks of slow speeds, and values of other codings', { skip }, async () => {
  async function check(bytes, attributes, what) {
    const mesh = await by_gpu(bytes, { attributes });
    assert.equal(difference(await decodeContainer(bytes, { attributes }), await mesh.read()), undefined, what);
    mesh.destroy();
  }
  // Patches of 1,000 faces have valence traversals.
  for (const options of [['--encode-speed', '0'], ['--encode-speed', '1'], ['--encode-speed', '2'], ['--encode-speed', '10'], ['--lossless'], ['--quantize-position', '20']]) {
    const { bytes, attributes } = make_container(700, 300, ...options);
    await check(bytes, attributes, options.join(' '));
  }
  const { bytes, attributes } = make_container(2400, 1200, '--encode-speed', '3');
  await check(bytes, attributes, 'valences');
});

test('without attributes, those of the first patch are decoded', { skip }, async () => {
  const { bytes } = make_container(400, 200), expected = await decodeContainer(bytes), mesh = await by_gpu(bytes), found = await mesh.read();
  const described = ({ name, uniqueId, type, componentCount, normalized }) => ({ name, uniqueId, type, componentCount, normalized });
  assert.deepEqual(found.attributes.map(described), expected.attributes.map(described));
  assert.equal(difference(expected, found), undefined);
  mesh.destroy();
});

test('quantized values are places on a grid', { skip }, async () => {
  const { bytes, attributes } = make_container(400, 200), expected = await decodeContainer(bytes, { attributes });
  const mesh = await by_gpu(bytes, { attributes }, 'quantized'), [places] = mesh.attributes, found = await mesh.read();
  assert.equal(places.type, 'uint16');
  assert.equal(places.stride, 8);
  const { scale, origin } = places, values = Float32Array.from(found.attributes[0].array, (place, i) => Math.fround(place * scale) + origin[i % 3]);
  assert.ok(are_equal(values, expected.attributes[0].array));
  mesh.destroy();
});

test('containers on the device, and at any place of a buffer', { skip }, async () => {
  const { bytes, attributes } = make_container(400, 200), expected = await decodeContainer(bytes, { attributes });
  for (const offset of [0, 8, 5]) {
    const buffer = device.createBuffer({ size: Math.ceil((offset + bytes.length) / 4) * 4, usage: GPUBufferUsage.COPY_SRC, mappedAtCreation: true });
    new Uint8Array(buffer.getMappedRange()).set(bytes, offset);
    buffer.unmap();
    const mesh = await by_gpu({ buffer, offset, byteLength: bytes.length }, { attributes });
    assert.equal(difference(expected, await mesh.read()), undefined);
    mesh.destroy();
    buffer.destroy();
  }
});

test('many containers at once, in several windows of memory; a broken one is not the failure of others', { skip }, async () => {
  const container = make_container(900, 100), small = await createGpuDecoder(device, { memory: 100000 });
  const { bytes, attributes } = container, list = Array.from({ length: 5 }, () => bytes), expected = await decodeContainer(bytes, { attributes });
  list[2] = bytes.slice(0, -1);
  const meshes = await small.decode(list, { attributes });
  for (const [i, mesh] of meshes.entries()) {
    if (i === 2) assert.equal(mesh.code, 'invalid-input');
    else assert.equal(mesh.way, 'gpu'), assert.equal(difference(expected, await mesh.read()), undefined), mesh.destroy();
  }
});

test('of several containers, some have lists of attributes', { skip }, async () => {
  const { bytes, attributes } = make_container(400, 200), [positions] = attributes;
  const meshes = await decoder.decode([bytes, bytes, bytes], { attributes: [undefined, [positions], attributes] });
  assert.deepEqual(meshes.map((mesh) => mesh.attributes?.length), [(await decodeContainer(bytes)).attributes.length, 1, attributes.length]);
  for (const mesh of meshes) mesh.destroy();
});

test('patches on several grids have no bounds, and no places', { skip }, async () => {
  const { bytes, attributes } = make_container(400, 200), places = await by_gpu(bytes, { attributes }, 'quantized'), other = bytes.slice();
  const origin = Buffer.from(Float32Array.from(places.attributes[0].origin).buffer), at = Buffer.from(other.buffer).lastIndexOf(origin);
  assert.ok(at > Buffer.from(other.buffer).indexOf(origin));
  new DataView(other.buffer).setFloat32(at, 7, true);
  const mesh = await by_gpu(other, { attributes });
  assert.equal(difference(await decodeContainer(other, { attributes }), await mesh.read()), undefined);
  assert.deepEqual([mesh.attributes[0].min, mesh.attributes[0].max], [undefined, undefined]);
  const by_wasm = await decoder.decode(other, { attributes, as: 'quantized' });
  assert.equal(by_wasm.way, 'wasm');
  for (const each of [places, mesh, by_wasm]) each.destroy();
});

// Normals and texture coordinates are not predicted from such fine positions.
const kByWasm = [400, 200, '--quantize-position', '24', '--encode-speed', '3'];
test('what the shaders do not decode goes through WebAssembly, and is uploaded', { skip }, async () => {
  const { bytes, attributes } = make_container(...kByWasm), mesh = await decoder.decode(bytes, { attributes });
  assert.equal(mesh.way, 'wasm');
  assert.match(mesh.why, /shaders/);
  assert.equal(difference(await decodeContainer(bytes, { attributes }), await mesh.read()), undefined);
  assert.ok(mesh.attributes.every(({ buffer }) => buffer instanceof GPUBuffer));
  mesh.destroy();
});

// A container that never comes to the device.
const of_residue = () => compressed_primitives(path.join(samples_folder, 'residue.glb'), 'PSPLIT_mesh_draco_patches')[0];
// The buffers of the device that were created while use() ran, and are not destroyed. Before the device creates one, use() may do something.
async function live_buffers(use) {
  const create = device.createBuffer, live = new Set();
  let created = 0;
  const run_with = (before) => {
    device.createBuffer = (descriptor) => {
      before?.(descriptor, created);
      const buffer = create.call(device, descriptor), destroy = buffer.destroy;
      ++created;
      live.add(buffer);
      buffer.destroy = () => (live.delete(buffer), destroy.call(buffer));
      return buffer;
    };
  };
  run_with();
  try {
    await use(run_with);
    return { created, live: live.size };
  } finally {
    delete device.createBuffer;
  }
}
test('an abort while WebAssembly decodes leaves no buffers', { skip }, async () => {
  const { bytes, attributes } = of_residue(), kTurns = 40;
  const { created, live } = await live_buffers(async () => {
    for (let turns = 0; turns < kTurns; ++turns) {
      const controller = new AbortController(), decoding = decoder.decode(bytes, { attributes, signal: controller.signal });
      const ended = decoding.then((mesh) => mesh.destroy(), (error) => assert.equal(error.code, 'aborted'));
      for (let turn = 0; turn < turns; ++turn) await null;
      controller.abort();
      await ended;
    }
    // What was begun has ended then.
    (await decoder.decode(bytes, { attributes })).destroy();
    await wait(200);
  });
  assert.ok(created > 1 + attributes.length, `${created} buffers`);
  assert.equal(live, 0);
});
test('memory that runs out while a mesh is uploaded', { skip }, async () => {
  const { bytes, attributes } = of_residue();
  const { created, live } = await live_buffers(async (run_with) => {
    run_with((_, count) => {
      if (count === 2) throw new RangeError('no more');
    });
    await assert.rejects(decoder.decode(bytes, { attributes }), { code: 'out-of-memory', message: /no more/ });
  });
  assert.deepEqual({ created, live }, { created: 2, live: 0 });
});
test('errors of the device have the code of their kind', { skip }, async () => {
  const { bytes, attributes } = make_container(400, 200), filters = [], { pushErrorScope, popErrorScope } = device;
  for (const [kinds, code] of [[['out-of-memory', 'validation'], 'out-of-memory'], [['validation'], 'failed'], [['internal'], 'failed']]) {
    device.pushErrorScope = (filter) => (filters.push(filter), pushErrorScope.call(device, filter));
    device.popErrorScope = async () => {
      const filter = filters.pop(), error = await popErrorScope.call(device);
      return kinds.includes(filter) ? new Error(code === 'failed' ? 'memory' : `of ${filter}`) : error;
    };
    await assert.rejects(decoder.decode(bytes, { attributes }), { code });
    delete device.pushErrorScope, delete device.popErrorScope;
  }
});

// This needs no device.
test('containers take as many words of a batch as their plans say', { skip: gltf_psplit === null && 'there is no gltf-psplit' }, async () => {
  const from_package = async (name) => import(pathToFileURL(path.join(package_folder, 'webgpu', name)));
  const { batches_of, fits } = await from_package('batch.js'), { ContainerPlan } = await from_package('container_plan.js'), { Layout } = await from_package('layout.js');
  const sizes = ({ plan, streams, attributes, walk_words, result_words, state_words }) => [plan.length, streams.length, attributes.length, walk_words, result_words, state_words];
  for (const options of [[700, 300], [2400, 1200, '--encode-speed', '3'], [400, 200, '--lossless']]) {
    const { bytes, attributes } = make_container(...options), plan = new ContainerPlan(bytes, attributes, 'float32', 1 << 25), layout = new Layout(1 << 25, [plan, plan, plan]);
    for (let i = 0; i < 3; ++i) plan.place(layout, 0);
    // Layout has the streams' states from the beginning.
    assert.deepEqual(sizes(layout), plan.sizes.map((words) => 3 * words), options.join(' '));
    const most = 4 * Math.max(bytes.length / 4 + 1, 64 * plan.stream_count, ...plan.sizes) + 8;
    assert.deepEqual([most - 12, most, 2 * most, 3 * most].map((limit) => fits(plan, limit)), [false, true, true, true]);
    assert.deepEqual([most, 2 * most, 9 * most].map((limit) => batches_of([plan, plan, plan], limit).map(({ length }) => length)), [[1, 1, 1], [2, 1], [3]]);
  }
});

// This needs no device. Of the counts in a head, libdraco stores one as a byte.
test('a number of attribute data in two bytes is refused', async () => {
  const { Reader, read_stream_head } = await import(pathToFileURL(path.join(package_folder, 'webgpu', 'stream_head.js')));
  const stream = readFileSync(new URL('../../bindings/web/examples/bundlers/stream.drc', import.meta.url));
  let at = 12;  // after the head's front
  const varint = () => {
    let value = 0;
    for (let shift = 0; ; shift += 7) {
      value |= (stream[at] & 127) << shift;
      if (stream[at++] < 128) return value;
    }
  };
  varint();
  const faces = varint(), head_of = (bytes) => read_stream_head(new Reader(bytes), 0, bytes.length, faces);
  assert.equal(head_of(stream).seams.length, stream[at]);
  assert.throws(() => head_of(Uint8Array.of(...stream.subarray(0, at), stream[at] | 128, 0, ...stream.subarray(at + 1))), /counts that contradict/);
});

test('errors: no device, limits, arguments, abort, a lost device', { skip }, async () => {
  const { bytes, attributes } = make_container(400, 200), expected = await decodeContainer(bytes, { attributes });
  await assert.rejects(createGpuDecoder(null), { code: 'failed', message: 'there is no GPU device' });
  const limits = { maxStorageBuffersPerShaderStage: 4, maxComputeInvocationsPerWorkgroup: 256 };
  await assert.rejects(createGpuDecoder({ limits }), /4 storage buffers/);
  for (const nothing of [null, { limits }]) {
    const mesh = await (await createGpuDecoder(nothing, { fallback: 'wasm' })).decode(bytes, { attributes });
    assert.deepEqual([mesh.way, mesh.indices.buffer], ['wasm', undefined]);
    assert.equal(difference(expected, await mesh.read()), undefined);
  }
  await assert.rejects(createGpuDecoder(device, { fallback: 'cpu' }), { code: 'invalid-input' });
  for (const memory of [NaN, -1, '64', null]) await assert.rejects(createGpuDecoder(device, { memory }), { code: 'invalid-input' });
  await assert.rejects(decoder.decode('bytes'), { code: 'invalid-input' });
  const buffer = device.createBuffer({ size: 64, usage: GPUBufferUsage.COPY_SRC }), { COPY_DST } = GPUBufferUsage;
  for (const range of [{ offset: NaN }, { offset: -4 }, { offset: 65 }, { offset: 1.5 }, { offset: '0' }, { byteLength: NaN }, { byteLength: 65 }, { offset: 32, byteLength: 33 }, { byteLength: -1 }])
    await assert.rejects(decoder.decode({ buffer, ...range }), { code: 'invalid-input', message: /GPU buffer/ });
  const odd = device.createBuffer({ size: 63, usage: GPUBufferUsage.COPY_SRC }), unreadable = device.createBuffer({ size: 64, usage: COPY_DST });
  await assert.rejects(decoder.decode(odd), { code: 'invalid-input', message: /no such words/ });
  await assert.rejects(decoder.decode(unreadable), { code: 'invalid-input', message: /COPY_SRC/ });
  for (const each of [buffer, odd, unreadable]) each.destroy();
  await assert.rejects(decoder.decode(bytes, { as: 'float16' }), { code: 'invalid-input' });
  await assert.rejects(decoder.decode(bytes.slice(1)), { code: 'invalid-input' });
  await assert.rejects(decoder.decode(bytes, { signal: AbortSignal.abort() }), { code: 'aborted' });
  const controller = new AbortController(), aborted = decoder.decode(bytes, { attributes, signal: controller.signal });
  controller.abort();
  await assert.rejects(aborted, { code: 'aborted' });

  const other = await request_device(), strict = await createGpuDecoder(other), lenient = await createGpuDecoder(other, { fallback: 'wasm' });
  other.destroy();
  await other.lost;
  await assert.rejects(strict.decode(bytes, { attributes }), /lost/);
  const mesh = await lenient.decode(bytes, { attributes });
  assert.equal(mesh.way, 'wasm');
  assert.equal(difference(expected, await mesh.read()), undefined);
});

// Mutants get the CPU's verdict and mesh. WebAssembly gives the verdict on a container that shaders refuse, so this tests that shaders
// end, leave the device as it was, and accept nothing else.
const kMutants = Number(process.env.PSPLIT_GPU_MUTANTS ?? 400);
async function check_hostile(make, count) {
  const sum = {};
  for (let first = 0; first < count; first += 50)
    add(sum, await compare(decoder, decodeContainer, Array.from({ length: Math.min(50, count - first) }, (_, i) => make(first + i))));
  assert.deepEqual(sum.differences, []);
  return sum;
}
// A GLB of one strip of triangles, whose positions and texture coordinates are any numbers from 0 to 1.
function strip(count, seed) {
  const random = random_numbers(seed), floats = (n) => Float32Array.from({ length: n * count }, () => random(65536) / 65536);
  const positions = floats(3), words = (...numbers) => Buffer.from(Uint32Array.from(numbers).buffer);
  positions.set([0, 0, 0, 1, 1, 1]);
  const indices = Array.from({ length: count - 2 }, (_, i) => (i % 2 === 0 ? [i, i + 1, i + 2] : [i + 1, i, i + 2])).flat();
  const parts = [words(...indices), positions, floats(2)].map(({ buffer, byteOffset, byteLength }) => Buffer.from(buffer, byteOffset, byteLength)), bytes = Buffer.concat(parts);
  const view = (i) => ({ buffer: 0, byteOffset: parts.slice(0, i).reduce((sum, { length }) => sum + length, 0), byteLength: parts[i].length });
  const text = JSON.stringify({ asset: { version: '2.0' }, buffers: [{ byteLength: bytes.length }], bufferViews: parts.map((_, i) => view(i)),
    accessors: [{ bufferView: 0, componentType: 5125, count: indices.length, type: 'SCALAR' },
      { bufferView: 1, componentType: 5126, count, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 1] }, { bufferView: 2, componentType: 5126, count, type: 'VEC2' }],
    meshes: [{ primitives: [{ indices: 0, attributes: { POSITION: 1, TEXCOORD_0: 2 } }] }], nodes: [{ mesh: 0 }], scenes: [{ nodes: [0] }], scene: 0 });
  const json = Buffer.from(text.padEnd(Math.ceil(text.length / 4) * 4)), chunks = Buffer.concat([words(json.length, 0x4e4f534a), json, words(bytes.length, 0x004e4942), bytes]);
  return Buffer.concat([words(0x46546c67, 2, 12 + chunks.length), chunks]);
}
test('texture coordinates of positions that are far apart have the verdict of the CPU', { skip }, async () => {
  const samples = Array.from({ length: 6 }, (_, seed) => make_container(strip(200, seed), 100, '--quantize-position', '20', '--quantize-texcoord', '20', '--encode-speed', '2'));
  assert.equal((await check_hostile((i) => ({ name: `strip ${i}`, ...samples[i] }), samples.length)).equal, samples.length);
  const range = (low, high) => Buffer.from(Int32Array.of(low, high).buffer);
  const sum = await check_hostile((i) => {
    // The range of positions, from twice as low on: products of differences take 64 bits.
    const { bytes, attributes } = samples[i], other = bytes.slice(), at = Buffer.from(other.buffer).indexOf(range(0, 2 ** 20 - 1));
    assert.ok(at > 0);
    other.set(range(-(2 ** 20), 2 ** 20), at);
    return { name: `far strip ${i}`, bytes: other, attributes };
  }, samples.length);
  assert.ok(sum.refused > 0);
});
test('mutants have the verdict of the CPU', { skip }, async (t) => {
  const samples = [make_container(200, 60), make_container(200, 60, '--encode-speed', '10'), make_container(200, 60, '--encode-speed', '3'), make_container(200, 60, '--encode-speed', '0'),
    make_container(2200, 1100, '--encode-speed', '3')], random = random_numbers(7);
  const sum = await check_hostile((i) => {
    const { bytes, attributes } = samples[i % samples.length], mutant = bytes.slice();
    for (let n = 1 + random(3); n > 0; --n) mutant[random(4) === 0 ? random(bytes.length) : 60 + random(bytes.length - 60)] ^= 1 << random(8);
    return { name: `mutant ${i}`, bytes: mutant, attributes };
  }, kMutants);
  t.diagnostic(JSON.stringify({ ...sum, reasons: undefined, differences: undefined }));
  assert.ok(sum.refused > kMutants / 20);
  assert.ok(sum.equal > kMutants / 20);
});
test('mutants of stitch maps', { skip }, async (t) => {
  const samples = [make_container(900, 60), make_container(900, 60, '--lossless')], random = random_numbers(11);
  const sum = await check_hostile((i) => {
    // The maps lie between the head and the first stream.
    const { bytes, attributes } = samples[i % samples.length], mutant = bytes.slice(), view = new DataView(bytes.buffer, bytes.byteOffset);
    const begin = 20 + view.getUint32(12, true) + view.getUint32(16, true), end = Buffer.from(bytes.buffer, bytes.byteOffset, bytes.length).indexOf('DRACO');
    assert.ok(end > begin + 50);
    mutant[begin + random(end - begin)] ^= 1 << random(8);
    return { name: `map ${i}`, bytes: mutant, attributes };
  }, kMutants / 2);
  // Some stay maps, of other points.
  t.diagnostic(JSON.stringify({ ...sum, reasons: undefined, differences: undefined }));
  assert.ok(sum.refused > kMutants / 4 && sum.equal > 0, JSON.stringify(sum));
});
test('containers that end early, or in zeros', { skip }, async () => {
  const { bytes, attributes } = make_container(60, 30), step = Math.ceil((2 * bytes.length) / kMutants);
  const length = (i) => Math.min(step * i, bytes.length - 1), count = Math.floor(bytes.length / step);
  const ended = await check_hostile((i) => ({ name: `${length(i)} bytes`, bytes: bytes.slice(0, length(i)), attributes }), count);
  assert.equal(ended.refused, count);
  await check_hostile((i) => ({ name: `${length(i)} bytes and zeros`, bytes: bytes.slice().fill(0, length(i)), attributes }), count);
});

test('the device decodes as before', { skip }, async () => {
  const { bytes, attributes } = make_container(400, 200), mesh = await by_gpu(bytes, { attributes });
  assert.equal(difference(await decodeContainer(bytes, { attributes }), await mesh.read()), undefined);
  mesh.destroy();
});
