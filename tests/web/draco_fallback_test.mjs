// psplit/draco with draco3d for older bitstreams: the answers are draco3d's, and draco3d is loaded late.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { page_test, skip as no_browser } from './browser.mjs';
import { ask } from './draco_answers.mjs';
import { corpus_folder, files_below, package_folder, stock } from './load.mjs';
import { encode_cloud, streams } from './stock_draco.mjs';

const { createDecoderModule } = createRequire(import.meta.url)(path.join(package_folder, 'draco/draco_wasm_wrapper.js'));
const theirs = await stock.createDecoderModule({}), ours = await createDecoderModule({ draco3d: theirs });
const alone = await createDecoderModule();

// Sequential point clouds of 2.1 have the layout of 2.3.
const cloud = encode_cloud(100, { method: 'sequential', metadata: true }).with(6, 1), [[, mesh]] = streams();
const is_newest = (bytes) => bytes[5] === 2 && bytes[6] >= 2;
const older = corpus_folder === null ? [] : files_below(corpus_folder, /\.drc$/).map((file) => [file, new Uint8Array(readFileSync(file))])
  .filter(([, bytes]) => !is_newest(bytes));

test('point clouds', () => {
  assert.deepEqual(ask(ours, cloud), ask(theirs, cloud));
  assert.deepEqual(ask(ours, cloud, ['POSITION']), ask(theirs, cloud, ['POSITION']));
  assert.equal(ask(alone, cloud).ok[0], false);
});

test('older bitstreams', { skip: corpus_folder === null && 'there is no corpus' }, () => {
  assert.ok(older.length >= 4, `${older.length} streams`);
  for (const [name, bytes] of older) {
    assert.deepEqual(ask(ours, bytes), ask(theirs, bytes), name);
    assert.deepEqual(ask(ours, bytes, ['POSITION', 'NORMAL']), ask(theirs, bytes, ['POSITION', 'NORMAL']), name);
    assert.equal(ask(alone, bytes).ok[0], false, name);
  }
});

test('metadata of a point cloud is that of draco3d', () => {
  const answers = [ours, theirs].map((draco) => {
    const decoder = new draco.Decoder(), points = new draco.PointCloud(), querier = new draco.MetadataQuerier();
    const status = decoder.DecodeArrayToPointCloud(new Int8Array(cloud), cloud.length, points);
    const metadata = decoder.GetMetadata(points);
    const answer = [status.ok(), querier.NumEntries(metadata), querier.GetIntEntry(metadata, 'number'), querier.GetStringEntry(metadata, 'title'),
      decoder.GetAttributeIdByName(points, 'place')];
    for (const object of [points, decoder]) draco.destroy(object);
    return answer;
  });
  assert.deepEqual(answers[0], answers[1]);
  assert.equal(answers[0][3], 'hills');
});

test("calls that psplit lacks are draco3d's, with any decoder", { skip: corpus_folder === null && 'there is no corpus' }, () => {
  const bytes = older.find(([, stream]) => stream[7] === 1)[1];
  const answers = [ours, theirs].map((draco) => {
    const decoder = new draco.Decoder(), other = new draco.Decoder(), out = new draco.Mesh();
    assert.ok(decoder.DecodeArrayToMesh(new Int8Array(bytes), bytes.length, out).ok());
    const strips = new draco.DracoInt32Array(), floats = new draco.DracoFloat32Array(), all = new draco.DracoFloat32Array();
    const attribute = other.GetAttribute(out, 0);
    return [other.GetTriangleStripsFromMesh(out, strips), strips.size(), strips.GetValue(1), other.GetAttributeFloat(attribute, 1, floats),
      floats.size(), floats.GetValue(0), other.GetAttributeFloatForAllPoints(out, attribute, all), all.GetValue(5)];
  });
  assert.deepEqual(answers[0], answers[1]);
  const decoder = new ours.Decoder(), out = new ours.Mesh();
  assert.ok(decoder.DecodeArrayToMesh(mesh, mesh.length, out).ok());
  assert.throws(() => decoder.GetTriangleStripsFromMesh(out, new ours.DracoInt32Array()), /psplit makes no triangle strips/);
});

test("draco3d's faults are passed on, and psplit's streams stay psplit's", () => {
  const newer = Uint8Array.from(mesh);
  newer[6] = 9;
  const status_of = (draco, bytes) => {
    const decoder = new draco.Decoder(), out = new draco.Mesh(), status = decoder.DecodeArrayToMesh(bytes, bytes.length, out);
    const result = [status.ok(), status.code(), status.error_msg()];
    draco.destroy(out);
    draco.destroy(decoder);
    return result;
  };
  assert.deepEqual(status_of(ours, newer), status_of(theirs, newer));
  assert.match(status_of(ours, mesh.subarray(0, 90))[2], /^psplit: Draco stream/);
});

test('an address is for classic workers', async () => {
  const draco = await createDecoderModule({ draco3d: 'https://example.com/draco3d/' });
  const decoder = new draco.Decoder(), status = decoder.DecodeArrayToPointCloud(cloud, cloud.length, new draco.PointCloud());
  assert.equal(status.ok(), false);
  assert.equal(status.error_msg(),
    'psplit: bitstream 2.1 is older than 2.2, the oldest that is decoded (draco3d can be loaded from an address in a classic worker only)');
});

// three's DRACOLoader, which decodes in workers made of blobs.
const sources = no_browser ? [] : [mesh, cloud, ...older.map(([, bytes]) => bytes)];
const files = { ...Object.fromEntries(sources.map((bytes, i) => [`/${i}.drc`, bytes])),
  '/': `<!doctype html><script type="importmap">{"imports":{"three":"/modules/three/build/three.module.js"}}</script>
    <script type="module" src="/main.js"></script>` };
async function load_all({ count, draco3d }) {
  const { DRACOLoader } = await import('/modules/three/examples/jsm/loaders/DRACOLoader.js'), { digest } = await import('/page.js');
  const loader = new DRACOLoader().setDecoderPath('/psplit/draco/').setWorkerLimit(1);
  if (draco3d !== undefined) loader.setDecoderConfig({ draco3d: new URL(draco3d, location.href).href });
  const answers = [];
  for (let i = 0; i < count; ++i) {
    answers.push(await loader.loadAsync(`/${i}.drc`).then(async (geometry) =>
      [geometry.index && await digest(geometry.index.array), await digest(geometry.getAttribute('position').array)], (error) => error.error ?? error.message));
  }
  loader.dispose();
  return answers;
}
const digest = (bytes) => createHash('sha256').update(bytes).digest('hex');
const expected = sources.map((bytes) => {
  const { triangles, attributes } = ask(theirs, bytes);
  return [triangles ? digest(triangles) : null, digest(attributes.find(({ facts }) => facts[0] === theirs.POSITION).arrays.FLOAT32)];
});
const folder = '/modules/three/examples/jsm/libs/draco/';

page_test("three's DRACOLoader with draco3d beside", { files, script: load_all, argument: { count: sources.length, draco3d: folder } },
  async ({ result, site }) => {
    assert.deepEqual(await result, expected);
    assert.equal(site.requests.filter((request) => request.startsWith(folder)).length, 2, 'draco3d is loaded once');
  });
page_test("three's DRACOLoader loads no draco3d if it needs none", { files, script: load_all, argument: { count: 1, draco3d: folder } },
  async ({ result, site }) => {
    assert.deepEqual(await result, expected.slice(0, 1));
    assert.deepEqual(site.requests.filter((request) => request.startsWith(folder)), []);
  });
page_test('a wrapper that names the folder of draco3d', { script: load_all, argument: { count: 2 }, files: { ...files,
  '/psplit/draco/draco_wasm_wrapper.js': `${readFileSync(path.join(package_folder, 'draco/draco_wasm_wrapper.js'), 'utf8')}
    DracoDecoderModule.draco3d = new URL('${folder}', self.location.origin).href;` } },
async ({ result }) => assert.deepEqual(await result, expected.slice(0, 2)));
page_test('no draco3d at the address', { files, script: load_all, argument: { count: 2, draco3d: '/nowhere/' }, errors: [/404/, /JSHandle@error/] },  // DRACOLoader logs its errors
  async ({ result }) => {
    const [decoded, message] = await result;
    assert.deepEqual(decoded, expected[0]);
    assert.match(message, /bitstream 2\.1 is older than 2\.2, the oldest that is decoded \(http.*\/nowhere\/draco_decoder\.wasm: HTTP status 404\)/);
  });

// The policy that the README names. The page's import map has a nonce.
page_test("three's DRACOLoader under a strict policy", { script: load_all, argument: { count: 1 },
  files: { ...files, '/': files['/'].replace('<script type="importmap">', '<script type="importmap" nonce="of-the-map">') },
  headers: { 'Content-Security-Policy': readFileSync(path.join(package_folder, 'README.md'), 'utf8').match(/^ *Content-Security-Policy: (.*worker-src blob:.*)$/m)[1]
    .replace("script-src 'self'", "script-src 'self' 'nonce-of-the-map'") } },
async ({ result }) => assert.deepEqual(await result, expected.slice(0, 1)));
