// psplit/draco where pages call it in unusual ways: reused objects, its heap, null objects, faulty headers, and every
// type of value. The answers are draco3d's, except where draco3d reads memory that holds something else.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { decoded, read_all, values_of } from './draco_answers.mjs';
import { modules_folder, package_folder, stock } from './load.mjs';
import { encode, encode_cloud, grid } from './stock_draco.mjs';

const { createDecoderModule } = createRequire(import.meta.url)(path.join(package_folder, 'draco/draco_wasm_wrapper.js'));
const ours = await createDecoderModule(), theirs = await stock.createDecoderModule({});
const newest = await createRequire(path.join(modules_folder, 'package.json'))('draco3d-newest').createDecoderModule();

const stock_heap = (await stock.createDecoderModule({})).HEAPU8;

const stream = (options) => encode(grid(10), { method: 'edgebreaker', speed: 5, bits: 11, extra: true, ...options });
const kSemantics = ['POSITION', 'NORMAL', 'COLOR', 'TEX_COORD', 'GENERIC'];

function same_answers(answer, message) {
  const expected = answer(theirs);
  assert.deepEqual(answer(newest), expected, `${message}: draco3d differs from itself`);
  assert.deepEqual(answer(ours), expected, message);
}

test('a reused mesh has the faces of its last stream', () => {
  const large = stream(), small = encode(grid(4), { method: 'sequential', speed: 5, bits: 11, extra: false });
  const last_face = (draco, { decoder, mesh }) => {
    const out = new draco.DracoInt32Array();
    return [decoder.GetFaceFromMesh(mesh, mesh.num_faces() - 1, out), ...values_of(out)];
  };
  const mesh = new ours.Mesh();
  for (const bytes of [small, large, small])
    assert.deepEqual(last_face(ours, decoded(ours, bytes, [], mesh)), last_face(theirs, decoded(theirs, bytes)));
});

test('memory of _malloc outlives errors of calls', async () => {
  const draco = await createDecoderModule(), at = draco._malloc(1 << 20);
  draco.HEAPU8.fill(7, at, at + (1 << 20));
  const decoder = new draco.Decoder(), mesh = new draco.Mesh();
  assert.equal(decoder.DecodeBufferToMesh(new draco.DecoderBuffer(), mesh).code(), draco.IO_ERROR);
  assert.throws(() => decoder.DecodeBufferToMesh(null, mesh), TypeError);
  const other = draco._malloc(100);
  assert.notEqual(other, at);
  assert.ok(draco.HEAPU8.subarray(at, at + (1 << 20)).every((value) => value === 7));
  draco._free(other);
  draco._free(other);  // changes nothing
  const blocks = Array.from({ length: 3 }, () => draco._malloc(100));
  assert.equal(new Set([...blocks, at]).size, 4);
  assert.ok(draco.HEAPU8.subarray(at, at + (1 << 20)).every((value) => value === 7));
});

test('views of memory that were taken before it grew', async () => {
  const draco = await createDecoderModule(), floats = draco.HEAPF32, bytes = draco.HEAPU8, before = bytes.length;
  assert.ok(before >= stock_heap.length, `${before} bytes`);
  assert.equal(draco.HEAPF32, floats);
  const at = draco._malloc(2 * before);
  assert.equal(floats.length, 0);  // JavaScript detached it
  assert.ok(draco.HEAPU8.length > before);
  new Float32Array(floats.buffer, at, 2).set([1.5, 2.5]);
  assert.deepEqual([...draco.HEAPF32.subarray(at / 4, at / 4 + 2)], [1.5, 2.5]);
  bytes.set([7, 8], at);
  assert.deepEqual([[...bytes.slice(at, at + 2)], [...bytes.subarray(at, at + 2)]], [[7, 8], [7, 8]]);
  assert.deepEqual([...draco.HEAPU8.subarray(at, at + 2)], [7, 8]);
});

test('memory has room for the values of a decoded mesh', async () => {
  const draco = await createDecoderModule(), { mesh } = decoded(draco, encode(grid(600), { method: 'edgebreaker', speed: 7, bits: 11, extra: true }));
  const { length } = draco.HEAPU8, sizes = [12 * mesh.num_faces(), ...Array.from({ length: mesh.num_attributes() }, (_, i) =>
    4 * mesh.num_points() * new draco.Decoder().GetAttribute(mesh, i).num_components())];
  assert.ok(length > 16 * 2 ** 20);
  for (const size of sizes) draco._free(draco._malloc(size));
  assert.equal(draco.HEAPU8.length, length);
});

test('a status that nobody destroys is not kept', async () => {
  const draco = await createDecoderModule(), bytes = stream(), mesh = new draco.Mesh(), decoder = new draco.Decoder();
  const status = () => decoder.DecodeArrayToMesh(bytes, bytes.length, mesh), first = draco.getPointer(status());
  for (let i = 0; i < 100; ++i) status();
  assert.equal(draco.getPointer(status()) - first, 8);
});

// A module whose decoding traps, as it does when memory runs out.
async function module_with_trap(config) {
  const { Instance } = WebAssembly, state = { traps: false };
  WebAssembly.Instance = class {
    constructor(...of) {
      const { exports } = new Instance(...of);
      this.exports = { ...exports, decode_stream: (...bytes) => {
        if (state.traps) throw new WebAssembly.RuntimeError('unreachable');
        return exports.decode_stream(...bytes);
      } };
    }
  };
  return { draco: await createDecoderModule(config), state, restore: () => (WebAssembly.Instance = Instance) };
}
test('memory of _malloc outlives a decoder that ran out of memory', async () => {
  const { draco, state, restore } = await module_with_trap();
  try {
    const bytes = stream(), before = decoded(draco, bytes), size = 12 * before.mesh.num_faces(), at = draco._malloc(size);
    draco.HEAPU8.fill(7, at, at + size);
    state.traps = true;
    const { status } = decoded(draco, bytes);
    assert.equal(status.code(), draco.DRACO_ERROR);
    assert.match(status.error_msg(), /out of memory/);
    state.traps = false;
    assert.ok(draco.HEAPU8.subarray(at, at + size).every((value) => value === 7));
    // Blocks that are made now do not lie in those before, and meshes are written to all.
    const blocks = Array.from({ length: 20 }, () => draco._malloc(size));
    assert.equal(new Set([...blocks, at]).size, 21);
    const after = decoded(draco, bytes), expected = decoded(theirs, bytes), there = theirs._malloc(size);
    assert.ok(expected.decoder.GetTrianglesUInt32Array(expected.mesh, size, there));
    for (const { decoder, mesh } of [before, after])
      for (const block of [at, blocks[19]]) {
        assert.ok(decoder.GetTrianglesUInt32Array(mesh, size, block));
        assert.deepEqual(draco.HEAPU8.slice(block, block + size), theirs.HEAPU8.slice(there, there + size));
      }
    for (const block of [at, ...blocks]) draco._free(block);
  } finally {
    restore();
  }
});

test('instantiateWasm makes the instance', async () => {
  const bytes = stream(), compiled = new WebAssembly.Module(readFileSync(path.join(package_folder, 'draco/draco_decoder.wasm')));
  for (const given of [[], [compiled]]) {
    const instantiateWasm = (imports, done) => {
      setTimeout(() => done(new WebAssembly.Instance(compiled, imports), ...given));
      return {};
    };
    const { draco, state, restore } = await module_with_trap({ instantiateWasm });
    try {
      assert.ok(decoded(draco, bytes).status.ok());
      state.traps = true;
      assert.match(decoded(draco, bytes).status.error_msg(), /out of memory/);
      state.traps = false;
      const { status } = decoded(draco, bytes);
      assert.equal(status.ok(), given.length > 0);
      if (!status.ok()) assert.match(status.error_msg(), /out of memory \(it was before\)/);
    } finally {
      restore();
    }
  }
});

test('null objects', () => {
  const bytes = stream();
  const missing = (draco) => {
    const { decoder, mesh } = decoded(draco, bytes), attribute = decoder.GetAttributeByUniqueId(mesh, 99);
    return { decoder, mesh, attribute };
  };
  same_answers((draco) => {
    const { attribute } = missing(draco);
    return [draco.getPointer(attribute), draco.compare(attribute, draco.NULL), attribute instanceof draco.PointAttribute];
  }, 'an attribute that the mesh lacks');
  // draco3d reads from address 0.
  const { decoder, mesh, attribute } = missing(ours), floats = new ours.DracoFloat32Array();
  assert.equal(ours.getPointer(decoder.GetAttribute(mesh, 99)), 0);
  for (const name of ['num_components', 'size', 'data_type', 'byte_stride', 'byte_offset']) assert.equal(attribute[name](), 0, name);
  assert.equal(attribute.normalized(), false);
  assert.equal(ours.getPointer(attribute.GetAttributeTransformData()), 0);
  assert.equal(decoder.GetAttributeFloatForAllPoints(mesh, attribute, floats), false);
  assert.equal(decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, ours.DT_FLOAT32, 0, 0), false);
  for (const kind of ['Quantization', 'Octahedron']) assert.equal(new ours[`Attribute${kind}Transform`]().InitFromAttribute(attribute), false);
  same_answers((draco) => {
    const { decoder, mesh } = decoded(draco, bytes), data = decoder.GetAttribute(mesh, 0).GetAttributeTransformData();
    return [draco.getPointer(data), data instanceof draco.AttributeTransformData];
  }, 'an attribute without a transform');
  same_answers((draco) => {
    const { decoder, mesh } = decoded(draco, bytes), querier = new draco.MetadataQuerier();
    return [decoder.GetMetadata(mesh), decoder.GetAttributeMetadata(mesh, 0)].map((metadata) =>
      [draco.getPointer(metadata), metadata instanceof draco.Metadata, querier.NumEntries(metadata), querier.HasEntry(metadata, 'name')]);
  }, 'a mesh without metadata');
  const face = new ours.DracoInt32Array();
  for (const beyond of [mesh.num_faces(), -1]) assert.equal(decoder.GetFaceFromMesh(mesh, beyond, face), false);
});

test('a stored value that an attribute lacks', () => {
  const { decoder, mesh } = decoded(ours, stream()), attribute = decoder.GetAttribute(mesh, 0), out = new ours.DracoFloat32Array();
  for (const number of [-1, attribute.size(), 2 ** 32]) assert.equal(decoder.GetAttributeFloat(attribute, number, out), false);
  assert.equal(decoder.GetAttributeFloat(decoder.GetAttributeByUniqueId(mesh, 99), 0, out), false);
});

test('status codes', () => {
  const bytes = stream(), cloud = encode_cloud(10);
  const codes = (draco, given) => {
    const decoder = new draco.Decoder(), status = decoder.DecodeArrayToMesh(new Int8Array(given), given.length, new draco.Mesh());
    const of_cloud = new draco.Decoder().DecodeArrayToPointCloud(new Int8Array(given), given.length, new draco.PointCloud());
    return [status.ok(), status.code(), of_cloud.code()];
  };
  for (let length = 0; length < 14; ++length) same_answers((draco) => codes(draco, bytes.slice(0, length)), `${length} bytes`);
  for (const [place, values] of [[0, [1]], [4, [0]], [5, [0, 3, 255]], [6, [3, 255]], [7, [0, 2]], [8, [2, 9]]])
    for (const value of values)
      same_answers((draco) => codes(draco, bytes.with(place, value)), `byte ${place} is ${value}`);
  assert.deepEqual(codes(ours, cloud).slice(0, 2), codes(theirs, cloud).slice(0, 2));
  for (const [place, value] of [[5, 1], [6, 1]]) assert.equal(codes(ours, bytes.with(place, value))[1], ours.UNSUPPORTED_VERSION);
});

test('the kind of a stream', () => {
  const bytes = stream();
  for (const given of [bytes, encode_cloud(10), bytes.with(0, 1), bytes.with(7, 2), bytes.subarray(0, 7), bytes.subarray(0, 8)])
    same_answers((draco) => new draco.Decoder().GetEncodedGeometryType(new Int8Array(given)), `${given.subarray(0, 8)}`);
  same_answers((draco) => new draco.Decoder().GetEncodedGeometryType(bytes.slice().buffer), 'an ArrayBuffer');
  assert.equal(new ours.Decoder().GetEncodedGeometryType(new ours.DecoderBuffer()), ours.INVALID_GEOMETRY_TYPE);
});

// Streams whose attributes are described with another type. Draco stores unquantized values as their bytes. Positions have
// bytes 0 and 1, because other bytes in place of bools are undefined in draco3d.
const { faces } = grid(5);
const bits_as_floats = (bits) => new Float32Array(Uint8Array.from({ length: 12 }, (_, i) => (bits >> i) & 1).buffer);
const bit_grid = { faces, points: Array.from({ length: 36 }, (_, i) => [...bits_as_floats(97 * (i + 1))]) };
function* retyped(bytes) {
  const { POSITION, TEX_COORD, DT_FLOAT32 } = theirs, bytes_of = [0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1];
  for (const [semantic, components] of [[POSITION, 3], [TEX_COORD, 2]]) {
    const at = bytes.findIndex((_, i) => [semantic, DT_FLOAT32, components, 0].every((value, k) => bytes[i + k] === value));
    if (at < 0) continue;
    for (let type = 1; type < bytes_of.length; ++type)
      for (const normalized of [0, 1])
        if ((4 * components) % bytes_of[type] === 0 && (type !== theirs.DT_BOOL || semantic === POSITION))
          yield bytes.with(at + 1, type).with(at + 2, (4 * components) / bytes_of[type]).with(at + 3, normalized);
  }
}

for (const method of ['edgebreaker', 'sequential']) {
  test(`each type of value: ${method}`, () => {
    for (const bits of [0, 11])
      for (const skipped of [[], kSemantics, ['COLOR'], ['GENERIC']]) {
        const bytes = stream({ method, bits });
        same_answers((draco) => read_all(decoded(draco, bytes, skipped), draco), `${bits} bits, ${skipped}`);
      }
  });
  test(`each type of stored value: ${method}`, () => {
    let count = 0;
    for (const bytes of retyped(encode(bit_grid, { method, speed: 10, bits: 0, extra: true }))) {
      const is_ok = decoded(theirs, bytes).status.ok();
      assert.equal(decoded(ours, bytes).status.ok(), is_ok, `${bytes}`);
      if (is_ok) same_answers((draco) => read_all(decoded(draco, bytes), draco), `${bytes}`);
      count += is_ok ? 1 : 0;
    }
    assert.ok(count >= 30, `${count} streams`);
  });
}
