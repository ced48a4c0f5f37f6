// Measures psplit/webgpu by Dawn, on a GPU's Vulkan driver, and compares what it decodes with WebAssembly's results:
//
//   node bench/web/webgpu.mjs [--quick] [--json FILE]
//
// VK_DRIVER_FILES names the driver. Times are the clock's, and the device's timestamps if it has some. If the processor runs the
// shaders, small meshes are compared, and no time is printed. scripts/gpu-check runs it.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { parseArgs } from 'node:util';
import { gunzipSync } from 'node:zlib';
import { compressed_primitives, corpus_folder, gltf_psplit, psplit } from '../../tests/web/load.mjs';
import { difference } from '../../tests/web/webgpu_compare.js';

// Dawn rounds timestamps to a tenth of a millisecond otherwise.
process.env.PSPLIT_DAWN ??= 'disable-dawn-features=timestamp_quantization';
const { createGpuDecoder, request_adapter, request_device, skip } = await import('../../tests/web/webgpu_device.mjs');

const { values: { quick, json } } = parseArgs({ options: { quick: { type: 'boolean', default: false }, json: { type: 'string' } } });
const kRounds = 5, kMost = 2 ** 32, median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];
const why = skip || (gltf_psplit === null && 'there is no gltf-psplit');
if (why) {
  console.log(`WebGPU: not run: ${why}`);
  process.exit();
}

const adapter = await request_adapter(), { info, features } = adapter;
const is_software = info.isFallbackAdapter === true || /swiftshader|llvmpipe|lavapipe|software/i.test(`${info.architecture} ${info.device} ${info.description}`);
console.log(`WebGPU: ${[info.vendor, info.architecture, info.device, info.description].filter(Boolean).join(', ')}`);
if (is_software) console.log('The processor runs the shaders: small meshes are compared, and no speed is measured.');

const has_timestamps = features.has('timestamp-query'), { maxStorageBufferBindingSize, maxBufferSize } = adapter.limits;
const device = await request_device({ requiredFeatures: has_timestamps ? ['timestamp-query'] : [], requiredLimits: { maxStorageBufferBindingSize, maxBufferSize } });

// The nanoseconds that passes of use() take on the device; NaN without timestamps. The decoder makes a pass for each batch.
async function measured(use) {
  const kMostPasses = 512, { createCommandEncoder } = device, { QUERY_RESOLVE, COPY_SRC, COPY_DST, MAP_READ } = GPUBufferUsage;
  if (!has_timestamps) return { result: await use(), ns: NaN };
  const queries = device.createQuerySet({ type: 'timestamp', count: 2 * kMostPasses });
  let passes = 0;
  device.createCommandEncoder = (descriptor) => {
    const encoder = createCommandEncoder.call(device, descriptor), { beginComputePass } = encoder;
    encoder.beginComputePass = () => beginComputePass.call(encoder, { timestampWrites: { querySet: queries, beginningOfPassWriteIndex: 2 * passes, endOfPassWriteIndex: 2 * passes++ + 1 } });
    return encoder;
  };
  const result = await use().finally(() => delete device.createCommandEncoder), size = 16 * passes;
  const resolved = device.createBuffer({ size, usage: QUERY_RESOLVE | COPY_SRC }), read = device.createBuffer({ size, usage: COPY_DST | MAP_READ });
  const encoder = device.createCommandEncoder();
  encoder.resolveQuerySet(queries, 0, 2 * passes, resolved, 0);
  encoder.copyBufferToBuffer(resolved, 0, read, 0, size);
  device.queue.submit([encoder.finish()]);
  await read.mapAsync(GPUMapMode.READ);
  const times = new BigUint64Array(read.getMappedRange());
  let ns = 0;
  for (let i = 0; i < passes; ++i) ns += Number(times[2 * i + 1] - times[2 * i]);
  for (const each of [resolved, read, queries]) each.destroy();
  return { result, ns };
}

const folder = mkdtempSync(path.join(tmpdir(), 'psplit-webgpu-')), file = (name) => path.join(folder, name);
const run = (...arguments_) => execFileSync(gltf_psplit, [...arguments_, '-q']);
function generated(faces, seed, ...options) {
  run('generate', file('mesh.glb'), '--shape', 'terrain', '--faces', String(faces), '--seed', String(seed));
  return encoded('mesh.glb', ...options);
}
function encoded(name, ...options) {
  run('encode', file(name), file('patches.glb'), ...options);
  return compressed_primitives(file('patches.glb'), 'PSPLIT_mesh_draco_patches')[0];
}
function dragon(name, ...options) {
  writeFileSync(file('dragon.ply'), gunzipSync(readFileSync(path.join(corpus_folder, 'mesh/dra', `${name}.ply.gz`))));
  return encoded('dragon.ply', ...options);
}

// Containers that are decoded in one call; the first `distinct` of them differ.
const repeated = (containers, count) => ({ list: Array.from({ length: count }, (_, i) => containers[i % containers.length]), distinct: containers.length });
const small = (count, faces, of_each) => repeated(Array.from({ length: of_each }, (_, seed) => generated(faces, seed + 1, '--always-patches', '--patches', '1')), count);
const kSets = is_software
  ? { 'terrain of 20,000 faces, 440 a patch': () => repeated([generated(20000, 1, '--patch-faces', '440')], 1),
    'a small Dragon, 440 faces a patch': () => corpus_folder && repeated([dragon('dragon_vrip_res4', '--patch-faces', '440')], 1),
    '40 primitives of 200 faces': () => small(40, 200, 4) }
  : { [`terrain of ${quick ? 1 : 10} million faces, 440 a patch`]: () => repeated([generated(quick ? 1e6 : 1e7, 1, '--patch-faces', '440')], 1),
    'Dragon, 440 faces a patch': () => corpus_folder && repeated([dragon('dragon_vrip', '--patch-faces', '440')], 1),
    '4,000 primitives of 2,000 faces': () => small(4000, 2000, 8) };

const memories = is_software ? [undefined] : [undefined, kMost], rows = [], decoders = [];
for (const memory of memories) decoders.push(await createGpuDecoder(device, { memory }));
if (!is_software) console.log('\n| containers | faces | memory | equal | device, ms | clock, ms | billion triangles a second |\n|---|--:|---|---|--:|--:|--:|');
let has_failed = false;
for (const [name, make] of Object.entries(kSets)) {
  const set = make();
  if (!set) {
    console.log(`${name}: not run: there is no corpus`);
    continue;
  }
  const { list, distinct } = set, data = list.map(({ bytes }) => bytes), attributes = list.map((container) => container.attributes);
  for (const [i, decoder] of decoders.entries()) {
    const device_ms = [], clock_ms = [];
    let what, faces;
    for (let round = is_software ? 0 : -1; round < (is_software ? 1 : kRounds); ++round) {
      const begin = performance.now(), { result: meshes, ns } = await measured(() => decoder.decode(data, { attributes })), end = performance.now();
      if (round === (is_software ? 0 : -1)) {
        // A warm-up, which is compared.
        for (const [k, mesh] of meshes.slice(0, distinct).entries())
          what ??= mesh.way !== 'gpu' ? `by ${mesh.way ?? mesh.message}: ${mesh.why}` : difference(await psplit.decodeContainer(data[k], { attributes: attributes[k] }), await mesh.read());
        what ??= meshes.find(({ way }) => way !== 'gpu')?.why;
        faces = meshes.reduce((sum, { faceCount }) => sum + faceCount, 0);
      } else {
        device_ms.push(ns / 1e6), clock_ms.push(end - begin);
      }
      for (const mesh of meshes) mesh.destroy?.();
    }
    has_failed ||= what !== undefined;
    const equal = what === undefined ? 'equal' : `DIFFERENT: ${what}`, of_decoder = memories[i] === undefined ? 'default' : '4 GiB';
    if (is_software) {
      console.log(`${name}: ${equal}, ${faces.toLocaleString('en-US')} faces in ${list.length} container${list.length > 1 ? 's' : ''}`);
      continue;
    }
    const on_device = median(device_ms), clock = median(clock_ms), rate = faces / (Number.isNaN(on_device) ? clock : on_device) / 1e6;
    rows.push({ name, faces, memory: of_decoder, equal, device_ms: Number.isNaN(on_device) ? null : on_device, clock_ms: clock, billion_triangles_per_s: rate });
    console.log(`| ${name} | ${faces.toLocaleString('en-US')} | ${of_decoder} | ${equal} | ${has_timestamps ? on_device.toFixed(2) : 'no timestamps'} | ${clock.toFixed(2)} | ${rate.toFixed(2)} |`);
  }
}
rmSync(folder, { recursive: true });
if (json !== undefined) writeFileSync(json, JSON.stringify({ adapter: { vendor: info.vendor, device: info.device, description: info.description }, is_software, rows }, null, 2));
device.destroy();
process.exit(has_failed ? 1 : 0);
