// psplit/webgpu in Node.js, on a processor: results, ways, errors, and hostile containers.
import assert from 'node:assert/strict';
import test, { after, before } from 'node:test';
import { gltf_psplit, make_container, psplit, random_numbers } from './load.mjs';
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

test('what the shaders do not decode goes through WebAssembly, and is uploaded', { skip }, async () => {
  for (const options of [[400, 200, '--condense'], [400, 200, '--quantize-position', '24', '--encode-speed', '3']]) {
    const { bytes, attributes } = make_container(...options), mesh = await decoder.decode(bytes, { attributes });
    assert.equal(mesh.way, 'wasm');
    assert.match(mesh.why, /condensed|shaders/);
    assert.equal(difference(await decodeContainer(bytes, { attributes }), await mesh.read()), undefined);
    assert.ok(mesh.attributes.every(({ buffer }) => buffer instanceof GPUBuffer));
    mesh.destroy();
  }
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
  await assert.rejects(decoder.decode('bytes'), { code: 'invalid-input' });
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

// The same verdict and the same mesh as the CPU's. A container that shaders refuse gets WebAssembly's verdict: so what is tested is that
// shaders end, leave the device as it was, and accept nothing else.
const kMutants = Number(process.env.PSPLIT_GPU_MUTANTS ?? 400);
async function check_hostile(make, count) {
  const sum = {};
  for (let first = 0; first < count; first += 50)
    add(sum, await compare(decoder, decodeContainer, Array.from({ length: Math.min(50, count - first) }, (_, i) => make(first + i))));
  assert.deepEqual(sum.differences, []);
  return sum;
}
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
