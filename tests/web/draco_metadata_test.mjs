// Metadata in psplit/draco: the calls have the answers of draco3d, for meshes and point clouds, and for trees that no encoder
// would write.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { values_of } from './draco_answers.mjs';
import { modules_folder, package_folder, random_numbers, stock } from './load.mjs';
import { encode, encode_cloud, grid, metadata_tree as tree, with_metadata } from './stock_draco.mjs';

const { createDecoderModule } = createRequire(import.meta.url)(path.join(package_folder, 'draco/draco_wasm_wrapper.js'));
const ours = await createDecoderModule(), theirs = await stock.createDecoderModule({});
const newest = await createRequire(path.join(modules_folder, 'package.json'))('draco3d-newest').createDecoderModule();

const cloud = encode_cloud(60, { types: [2, 5] }), sequential = encode_cloud(60, { method: 'sequential' });
const meshes = ['edgebreaker', 'sequential'].map((method) => encode(grid(6), { method, speed: 5, bits: 11, extra: true }));
const kHosts = [cloud, sequential, ...meshes];
const kNames = ['name', 'title', 'number', 'some', 'half', '', 'é', 'a\0b', 'a', 'missing', 'x'.repeat(255)];

// Of bytes that are no text, draco3d makes characters of its own.
const text_or_none = (string) => (/[^\0-\u04ff]/.test(string) ? undefined : string);
// What can be asked of metadata.
function read_metadata(draco, querier, metadata) {
  const count = querier.NumEntries(metadata), names = Array.from({ length: count + 2 }, (_, i) => querier.GetEntryName(metadata, i - 1));
  const values = [...new Set([...kNames, ...names])].map((name) => {
    const integers = new draco.DracoInt32Array();
    querier.GetIntEntryArray(metadata, name, integers);
    return [name, querier.HasEntry(metadata, name), querier.GetIntEntry(metadata, name), querier.GetDoubleEntry(metadata, name),
      text_or_none(querier.GetStringEntry(metadata, name)), values_of(integers)];
  });
  return { count, names, values };
}
function answers(draco, bytes, skipped = []) {
  const is_mesh = bytes[7] === draco.TRIANGULAR_MESH, decoder = new draco.Decoder(), points = is_mesh ? new draco.Mesh() : new draco.PointCloud();
  const querier = new draco.MetadataQuerier();
  for (const semantic of skipped) decoder.SkipAttributeTransform(draco[semantic]);
  try {
    const status = decoder[is_mesh ? 'DecodeArrayToMesh' : 'DecodeArrayToPointCloud'](new Int8Array(bytes), bytes.length, points);
    const facts = [status.ok(), status.code()];
    if (!status.ok()) return facts;
    const of_geometry = decoder.GetMetadata(points);
    facts.push(draco.getPointer(of_geometry) !== 0, draco.compare(of_geometry, decoder.GetMetadata(points)), of_geometry instanceof draco.Metadata);
    if (draco.getPointer(of_geometry) !== 0) facts.push(read_metadata(draco, querier, of_geometry));
    for (let i = 0; i < points.num_attributes(); ++i) {
      const metadata = decoder.GetAttributeMetadata(points, i);
      facts.push(draco.getPointer(metadata) !== 0);
      if (draco.getPointer(metadata) !== 0) facts.push(read_metadata(draco, querier, metadata), draco.compare(metadata, decoder.GetAttributeMetadata(points, i)));
    }
    const texts = ['place', 'colour', '', 'é', 'a\0b', 'a', 'missing', 'hills'];
    facts.push(texts.map((text) => [decoder.GetAttributeIdByName(points, text),
      ...['name', 'title', '', 'é', 'missing'].map((name) => decoder.GetAttributeIdByMetadataEntry(points, name, text))]));
    return facts;
  } finally {
    for (const object of [points, decoder, querier]) draco.destroy(object);
  }
}
function same_answers(bytes, message, skipped) {
  const expected = answers(theirs, bytes, skipped);
  assert.deepEqual(answers(newest, bytes, skipped), expected, `${message}: draco3d differs from itself`);
  assert.deepEqual(answers(ours, bytes, skipped), expected, message);
  return expected[0];
}

const text = (string) => [...Buffer.from(string)];
const bytes_of = (...numbers) => [...new Uint8Array(numbers[0].buffer)];
const kEntries = [['title', text('hills')], ['number', bytes_of(Int32Array.of(-7))], ['some', bytes_of(Int32Array.of(1, -2, 3))],
  ['half', bytes_of(Float64Array.of(0.5))], ['name', text('x')], ['é', text('é')], ['', [1]], ['a\0b', text('a\0b')], ['a', text('a')],
  ['x'.repeat(255), text('long '.repeat(100))], ['Z', [0]], ['number2', [1, 2, 3]]];

test('metadata that the encoder writes', () => {
  for (const method of ['kd-tree', 'sequential']) {
    const bytes = encode_cloud(60, { method, types: [2, 5], metadata: true });
    assert.ok(same_answers(bytes, method));
    assert.ok(same_answers(bytes, `${method}, skipped`, ['POSITION', 'COLOR', 'GENERIC']));
    assert.ok(JSON.stringify(answers(ours, bytes)).includes('hills'));
  }
});

test('each kind of stream and of entry', () => {
  for (const host of kHosts) {
    assert.ok(same_answers(host, 'no metadata'));
    assert.ok(same_answers(with_metadata(host, [], tree([])), 'no entries'));
    assert.ok(same_answers(with_metadata(host, [], tree(kEntries)), 'of the geometry'));
    assert.ok(same_answers(with_metadata(host, [[1, tree(kEntries)], [0, tree([['name', text('place')]])], [77, tree([['name', text('colour')]])],
      [1, tree([['title', text('hills')]])]], tree([['name', text('place')]])), 'of attributes'));
    assert.ok(same_answers(with_metadata(host, [], tree([['title', text('first')], ['title', text('second')]])), 'an entry twice'));
    assert.ok(same_answers(with_metadata(host, [], tree(kEntries.slice(0, 2), [['part', tree(kEntries, [['inner', tree([])]])], ['other', tree([])]])), 'parts'));
    for (const [message, entries] of [['an empty value', [['title', []]]], ['an empty value later', [['name', [1]], ['title', []]]]])
      same_answers(with_metadata(host, [], tree(entries)), message);
  }
});

test('parts that repeat a name or nest too deeply', () => {
  const nested = (depth) => {
    let inner = tree([]);
    for (let i = 0; i < depth; ++i) inner = [0, 1, 2, 105, 110, ...inner];
    return inner;
  };
  for (const host of kHosts) {
    assert.equal(same_answers(with_metadata(host, [], tree([], [['part', tree([])], ['part', tree([])]])), 'twice'), false);
    assert.ok(same_answers(with_metadata(host, [], tree([], [['part', tree([], [['part', tree([])]])], ['other', tree([], [['part', tree([])]])]])), 'elsewhere'));
    for (const depth of [999, 1000, 1001, 1002, 1003, 3000]) same_answers(with_metadata(host, [], nested(depth)), `depth ${depth}`);
    assert.equal(answers(ours, with_metadata(host, [], nested(1003)))[0], false);
    assert.equal(answers(ours, with_metadata(host, [], nested(1001)))[0], true);
  }
});

test('broken metadata', () => {
  const random = random_numbers(5);
  let good = 0;
  for (const host of kHosts) {
    const whole = with_metadata(host, [[1, tree(kEntries.slice(0, 3))]], tree(kEntries.slice(2, 5), [['part', tree(kEntries.slice(0, 2))]]));
    const size = whole.length - host.length;
    for (let length = 11; length < size + 20; ++length) same_answers(whole.subarray(0, length), `${length} bytes`);
    for (let i = 0; i < 300; ++i) {
      const broken = Uint8Array.from(whole);
      for (let k = 0; k <= i % 3; ++k) broken[11 + random(size)] = i % 2 === 0 ? random(128) : random(8);
      good += same_answers(broken, `mutant ${i}: ${broken}`) ? 1 : 0;
    }
  }
  assert.ok(good > 100, `${good} mutants decode`);
});

test('metadata ends with its mesh, and a new one has no entries', () => {
  const decoder = new ours.Decoder(), mesh = new ours.PointCloud(), querier = new ours.MetadataQuerier();
  const bytes = encode_cloud(60, { metadata: true });
  assert.ok(decoder.DecodeArrayToPointCloud(bytes, bytes.length, mesh).ok());
  const metadata = decoder.GetMetadata(mesh);
  assert.equal(ours.wrapPointer(ours.getPointer(metadata)), metadata);
  assert.ok(decoder.DecodeArrayToPointCloud(cloud, cloud.length, mesh).ok());
  assert.equal(ours.getPointer(metadata), 0);
  assert.equal(ours.getPointer(decoder.GetMetadata(mesh)), 0);
  assert.equal(ours.getPointer(decoder.GetAttributeMetadata(mesh, 99)), 0);
  for (const draco of [ours, theirs]) assert.equal(new draco.MetadataQuerier().NumEntries(new draco.Metadata()), 0);
  assert.equal(querier.HasEntry(decoder.GetMetadata(mesh), 'name'), false);
});
