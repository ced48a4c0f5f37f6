// Memory stays as it is, however many streams fail: in psplit/draco, in the functions, in a pool, and in both encoders.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { package_folder, psplit, random_numbers } from './load.mjs';
import { encode, grid } from './stock_draco.mjs';

const require = createRequire(import.meta.url);
const kTimes = 10000, kWarmUp = 500, kMiB = 1024 * 1024;

// Streams of several sizes: whole, cut off, and with a byte that is another.
const whole = [4, 12, 40].map((size) => encode(grid(size), { method: 'edgebreaker', speed: 5, bits: 11, extra: size < 40 }));
function* mixed_streams(times) {
  const random = random_numbers(times);
  for (let i = 0; i < times; ++i) {
    const bytes = whole[random(whole.length)], kind = random(4);
    yield kind === 0 ? bytes : kind === 1 ? bytes.with(random(bytes.length), random(256)) : bytes.subarray(0, random(bytes.length));
  }
}

// Calls use(i) for i of 0 to kTimes - 1, and returns how much the memory of all instances that are made grew after the first ones.
async function growth(make, use) {
  const { Instance } = WebAssembly, memories = new Set();
  WebAssembly.Instance = function (...of) {
    const instance = new Instance(...of);
    memories.add(instance.exports.memory);
    return instance;
  };
  try {
    const state = await make(), bytes = () => [...memories].reduce((sum, { buffer }) => sum + buffer.byteLength, 0);
    let before;
    for (let i = 0; i < kTimes; ++i) {
      if (i === kWarmUp) before = bytes();
      await use(state, i);
    }
    assert.ok(memories.size > 0);
    return bytes() - before;
  } finally {
    WebAssembly.Instance = Instance;
  }
}
const count_of = async (use) => {
  const counts = { good: 0, bad: 0 };
  const grown = await use((is_good) => ++counts[is_good ? 'good' : 'bad']);
  assert.ok(counts.good > kTimes / 10 && counts.bad > kTimes / 10, JSON.stringify(counts));
  return grown;
};

test('psplit/draco', async () => {
  const streams = mixed_streams(kTimes);
  assert.equal(await count_of((count) => growth(require(path.join(package_folder, 'draco/draco_wasm_wrapper.js')).createDecoderModule, (draco) => {
    const { value: bytes } = streams.next(), decoder = new draco.Decoder(), mesh = new draco.Mesh();
    count(decoder.DecodeArrayToMesh(bytes, bytes.length, mesh).ok());
    draco.destroy(mesh);
    draco.destroy(decoder);
  })), 0);
});

test('a mesh that lives while others fail', async () => {
  const streams = mixed_streams(kTimes);
  assert.equal(await growth(require(path.join(package_folder, 'draco/draco_wasm_wrapper.js')).createDecoderModule, (draco, i) => {
    const { value: bytes } = streams.next(), decoder = new draco.Decoder(), mesh = new draco.Mesh(), kept = (draco.kept ??= []);
    if (decoder.DecodeArrayToMesh(bytes, bytes.length, mesh).ok()) kept.push(mesh);
    else draco.destroy(mesh);
    if (kept.length === 3 || i === kWarmUp - 1) for (const old of kept.splice(0)) draco.destroy(old);
    draco.destroy(decoder);
  }) < 4 * kMiB, true);
});

test('decodeDraco and decodeContainer', async () => {
  const { configure, decodeContainer, decodeDraco } = psplit, streams = mixed_streams(kTimes);
  assert.equal(await count_of((count) => growth(() => configure(), async (_, i) => {
    const { value: bytes } = streams.next();
    if (i % 10 === 9) await decodeContainer(bytes, { attributes: [] }).catch(({ code }) => assert.equal(code, 'invalid-input'));
    else await decodeDraco(bytes).then(() => count(true), () => count(false));
  })) < kMiB, true);
});

// Workers have instances of their own, so the process is measured.
test('a pool', async () => {
  const pool = psplit.createPool({ workers: 2 }), rss = () => process.memoryUsage().rss;
  let before;
  try {
    await count_of(async (count) => {
      const streams = [...mixed_streams(kTimes)];
      for (let i = 0; i < kTimes; i += 100) {
        if (i === 10 * kWarmUp / 5) before = rss();
        await Promise.all(streams.slice(i, i + 100).map((bytes) => pool.decodeDraco(bytes).then(() => count(true), () => count(false))));
      }
    });
    const grown = rss() - before;
    assert.ok(grown < 150 * kMiB, `${grown / kMiB} MiB`);
  } finally {
    pool.dispose();
  }
});

test('the encoder of psplit/draco', async () => {
  const { points, faces } = grid(10), positions = Float32Array.from(points.flat()), good = Uint32Array.from(faces.flat());
  const bad = good.with(7, points.length + 5);
  assert.equal(await count_of((count) => growth(require(path.join(package_folder, 'draco/draco_encoder.js')).createEncoderModule, (draco, i) => {
    const encoder = new draco.Encoder(), builder = new draco.MeshBuilder(), mesh = new draco.Mesh(), out = new draco.DracoInt8Array();
    builder.AddFacesToMesh(mesh, faces.length, i % 3 === 0 ? good : bad);
    builder.AddFloatAttributeToMesh(mesh, draco.POSITION, points.length, 3, positions);
    encoder.SetAttributeQuantization(draco.POSITION, 11);
    count(encoder.EncodeMeshToDracoBuffer(mesh, out) > 0);
    for (const object of [out, mesh, builder, encoder]) draco.destroy(object);
  })), 0);
});

// Each call has an instance of its own.
test('psplit/encode', async () => {
  const { encodeMesh } = await import(pathToFileURL(path.join(package_folder, 'encode.js')));
  const { points, faces } = grid(6), rss = () => process.memoryUsage().rss, attributes = { POSITION: { array: Float32Array.from(points.flat()), componentCount: 3 } };
  const good = Uint32Array.from(faces.flat()), bad = good.with(3, points.length);
  let before;
  const counts = { good: 0, bad: 0 };
  for (let i = 0; i < 1000; ++i) {
    if (i === 200) before = rss();
    await encodeMesh({ indices: i % 2 === 0 ? good : bad, attributes }).then(() => ++counts.good, () => ++counts.bad);
  }
  assert.deepEqual(counts, { good: 500, bad: 500 });
  assert.ok(rss() - before < 150 * kMiB, `${(rss() - before) / kMiB} MiB`);
});
