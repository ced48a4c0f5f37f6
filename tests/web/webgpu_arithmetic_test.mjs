// The arithmetic of the shaders: floats that are computed in integers equal IEEE 754's, and integers of 64 bits BigInt's.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { random_numbers, root } from './load.mjs';
import { request_device, skip } from './webgpu_device.mjs';

// Not of the package, which has other names.
const shaders_of = async (name) => import(pathToFileURL(path.join(root, 'bindings/web/js/webgpu', name)));
const { floats } = await shaders_of('floats.wgsl.js'), { integers } = await shaders_of('integers.wgsl.js');

// Computes out[i] = `expression` of a = words[2 i] and b = words[2 i + 1], each of two words.
async function compute(code, expression, words) {
  const device = await request_device(), { STORAGE, COPY_DST, COPY_SRC, MAP_READ } = GPUBufferUsage;
  const module = device.createShaderModule({ code: `${code}
    @group(0) @binding(0) var<storage, read> words: array<vec2u>;
    @group(0) @binding(1) var<storage, read_write> out: array<vec2u>;
    @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
      if (id.x >= arrayLength(&out)) { return; }
      let a = words[2u * id.x];
      let b = words[2u * id.x + 1u];
      out[id.x] = ${expression};
    }` });
  const pipeline = await device.createComputePipelineAsync({ layout: 'auto', compute: { module, entryPoint: 'main' } });
  const input = device.createBuffer({ size: words.byteLength, usage: STORAGE | COPY_DST }), size = words.byteLength / 2;
  const output = device.createBuffer({ size, usage: STORAGE | COPY_SRC }), copy = device.createBuffer({ size, usage: MAP_READ | COPY_DST });
  device.queue.writeBuffer(input, 0, words);
  const encoder = device.createCommandEncoder(), pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries: [input, output].map((buffer, binding) => ({ binding, resource: { buffer } })) }));
  pass.dispatchWorkgroups(Math.ceil(size / 8 / 64));
  pass.end();
  encoder.copyBufferToBuffer(output, 0, copy, 0, size);
  device.queue.submit([encoder.finish()]);
  await copy.mapAsync(GPUMapMode.READ);
  const found = new Uint32Array(copy.getMappedRange()).slice();
  device.destroy();
  return found;
}

const random = random_numbers(3), word = () => random(65536) * 65536 + random(65536);
const as_float = (bits) => new Float32Array(Uint32Array.of(bits).buffer)[0], as_bits = (value) => new Uint32Array(Float32Array.of(value).buffer)[0];
const kCount = 20000, kSpecial = [0, 0x80000000, 1, 0x80000001, 0x007fffff, 0x00800000, 0x3f800000, 0xbf800000, 0x7f7fffff, 0xff7fffff, 0x33800000, 0x4b800000];
// Any finite float, or one of few bits, or near 1, so that sums cancel and products lie between two floats.
function some_float() {
  const kind = random(4), sign = random(2) * 0x80000000;
  if (kind === 0) return kSpecial[random(kSpecial.length)];
  if (kind === 1) return sign + random(255) * 0x800000 + random(0x800000);
  if (kind === 2) return sign + (120 + random(16)) * 0x800000 + random(16) * 0x80000;
  return sign + (126 + random(3)) * 0x800000 + random(0x800000);
}

test('floats in integers', { skip }, async () => {
  const words = Uint32Array.from({ length: 4 * kCount }, (_, i) => (i % 2 === 0 ? some_float() : 0));
  for (const [name, expression, expected] of [['multiply', 'vec2u(multiply(a.x, b.x), 0u)', (a, b) => a * b], ['add', 'vec2u(add(a.x, b.x), 0u)', (a, b) => a + b],
    ['divide', 'vec2u(select(divide(a.x, b.x), 0x7fc00000u, is_zero(b.x)), 0u)', (a, b) => (b === 0 ? NaN : a / b)],
    ['square_root', 'vec2u(square_root(a.x & 0x7fffffffu), 0u)', (a) => Math.sqrt(Math.abs(a))],
    ['float_of', 'vec2u(float_of(i32(a.x)), 0u)', (a, b, bits) => bits | 0]]) {
    const found = await compute(floats, expression, words);
    for (let i = 0; i < kCount; ++i) {
      const a = words[4 * i], b = words[4 * i + 2], wanted = as_bits(Math.fround(expected(as_float(a), as_float(b), a)));
      assert.equal(found[2 * i], wanted, `${name}(${a.toString(16)}, ${b.toString(16)})`);
    }
  }
});

test('integers of 64 bits', { skip }, async () => {
  // Numbers of any length, so that quotients are not all 0.
  const words = new Uint32Array(4 * kCount), wide = new BigUint64Array(words.buffer);
  for (let i = 0; i < wide.length; ++i) wide[i] = ((BigInt(word()) << 32n) | BigInt(word())) >> BigInt(random(64));
  const signed = (x) => BigInt.asIntN(64, x), unsigned = (x) => BigInt.asUintN(64, x);
  function root(x) {
    let low = 0n;
    for (let bit = 1n << 31n; bit > 0n; bit >>= 1n) if ((low + bit) * (low + bit) <= x) low += bit;
    return low;
  }
  for (const [name, expression, expected] of [['plus', 'plus(a, b)', (a, b) => a + b], ['minus', 'minus(a, b)', (a, b) => a - b], ['times', 'times(a, b)', (a, b) => a * b],
    ['product', 'product(i32(a.x), i32(b.x))', (a, b) => BigInt.asIntN(32, a) * BigInt.asIntN(32, b)], ['wide_root', 'wide_root(a)', root],
    ['quotient', 'quotient(a, vec2u(b.x | 1u, b.y & 0x7fffffffu))', (a, b) => signed(a) / ((b | 1n) & ((1n << 63n) - 1n))]]) {
    const found = new BigUint64Array((await compute(integers, expression, words)).buffer);
    for (let i = 0; i < kCount; ++i) assert.equal(found[i], unsigned(expected(wide[2 * i], wide[2 * i + 1])), `${name}(${wide[2 * i]}, ${wide[2 * i + 1]})`);
  }
});
