// Chromium computes what draco3d and gltf-psplit compute: streams, containers, and loaders that use psplit/draco/.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { page_test, skip as no_browser } from './browser.mjs';
import { compressed_primitives, corpus_folder, corpus_streams, root } from './load.mjs';
import { decode, streams } from './stock_draco.mjs';

const digest = (array) =>
  createHash('sha256').update(new Uint8Array(array.buffer, array.byteOffset, array.byteLength)).digest('hex');
const digests = ({ faceCount, pointCount, indices, attributes }) => ({ faceCount, pointCount, indices: digest(indices),
  attributes: attributes.map(({ uniqueId, componentCount, array }) =>
    ({ uniqueId, componentCount, type: array.constructor.name, values: digest(array) })) });

// All streams of the tests. Chromium must answer with what draco3d decodes, or with an error.
const all = no_browser ? [] : [...streams(), ...(corpus_folder === null ? [] : corpus_streams())];
const is_supported = ([, bytes]) => bytes[7] === 1 && bytes[5] === 2 && bytes[6] === 2;
const files = (list) => Object.fromEntries(list.map(([, bytes], i) => [`/${i}.drc`, bytes]));

page_test('streams, on the calling thread and in a pool', { files: files(all), argument: all.length, script: async (count) => {
  const { createPool, decodeDraco } = await import('/psplit/index.js'), { digests, fetch_bytes } = await import('/page.js');
  const pool = createPool({ workers: 2 }), code = ({ name, code }) => `${name} ${code}`;
  const answers = await Promise.all(Array.from({ length: count }, async (_, i) => {
    const bytes = await fetch_bytes(`/${i}.drc`);
    return Promise.all([decodeDraco(bytes).then(digests, code), pool.decodeDraco(bytes).then(digests, code)]);
  }));
  pool.dispose();
  return answers;
} }, async ({ result }) => {
  const answers = await result;
  let same = 0;
  for (const [i, [name, bytes]] of all.entries()) {
    const expected = is_supported([name, bytes]) ? digests(decode(bytes))
      : `PsplitError ${bytes[7] === 1 ? 'unsupported' : 'invalid-input'}`;
    assert.deepEqual(answers[i], [expected, expected], name);
    if (is_supported([name, bytes])) ++same;
  }
  assert.ok(same >= (corpus_folder === null ? 40 : 60), `${same} streams`);
});

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const expected_samples = JSON.parse(readFileSync(path.join(samples, 'expected.json')));
const containers = Object.entries(expected_samples).flatMap(([name, { primitives }]) =>
  compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches')
    .map(({ bytes, attributes }, i) => ({ name, bytes, attributes,
      expected: { ...primitives[i], attributes_sha256: { ...primitives[i].attributes_sha256, ...primitives[i].targets_sha256 } } })));

page_test('containers, on the calling thread and in a pool', {
  files: Object.fromEntries(containers.map(({ bytes }, i) => [`/${i}.bin`, bytes])),
  argument: containers.map(({ attributes }) => attributes),
  script: async (requests) => {
    const { createPool, decodeContainer } = await import('/psplit/index.js'), { digest, fetch_bytes } = await import('/page.js');
    const pool = createPool({ workers: 2 });
    const facts = async ({ pointCount, indices, attributes }) => ({ points: pointCount, indices: indices.length,
      indices_sha256: await digest(indices),
      attributes_sha256: Object.fromEntries(await Promise.all(
        attributes.map(async ({ name, array }) => [name, await digest(array)]))) });
    const answers = await Promise.all(requests.map(async (attributes, i) => {
      const bytes = await fetch_bytes(`/${i}.bin`);
      return Promise.all([decodeContainer, (...of) => pool.decodeContainer(...of)]
        .map((decode) => decode(bytes, { attributes }).then(facts)));
    }));
    pool.dispose();
    return answers;
  },
}, async ({ result }) => {
  const answers = await result;
  assert.ok(containers.length >= 9);
  for (const [i, { name, expected }] of containers.entries())
    for (const answer of answers[i])
      for (const [fact, value] of Object.entries(answer)) assert.deepEqual(value, expected[fact], `${name}: ${fact}`);
});

// Loaders have the faces and values that draco3d decodes. The values are 32-bit floats.
const all_attributes = all.filter(([name]) => name.includes('more attributes'));
const import_map = (imports) => `<!doctype html><script type="importmap">${JSON.stringify({ imports })}</script>
  <script type="module" src="/main.js"></script>`;

page_test("three's DRACOLoader on psplit/draco", {
  files: { ...files(all_attributes), '/': import_map({ three: '/modules/three/build/three.module.js' }) },
  argument: all_attributes.length,
  script: async (count) => {
    const { DRACOLoader } = await import('/modules/three/examples/jsm/loaders/DRACOLoader.js');
    const { digest } = await import('/page.js');
    const loader = new DRACOLoader().setDecoderPath('/psplit/draco/').setWorkerLimit(2);
    const answers = await Promise.all(Array.from({ length: count }, async (_, i) => {
      const { index, attributes } = await loader.loadAsync(`/${i}.drc`);
      return { indices: await digest(index.array), position: await digest(attributes.position.array),
        normal: await digest(attributes.normal.array), uv: await digest(attributes.uv.array) };
    }));
    loader.dispose();
    return answers;
  },
}, async ({ result, site }) => {
  const answers = await result;
  assert.ok(answers.length === 20);
  for (const [i, [name, bytes]] of all_attributes.entries()) {
    const { indices, attributes: [position, normal, uv] } = decode(bytes);
    assert.deepEqual(answers[i], { indices: digest(indices), position: digest(position.array), normal: digest(normal.array),
      uv: digest(uv.array) }, name);
  }
  assert.ok(site.requests.includes('/psplit/draco/draco_decoder.wasm'));
});

for (const workers of [2, 0])
  page_test(`Babylon.js' DracoDecoder on psplit/draco, ${workers} workers`, {
    files: { ...files(all_attributes), '/': import_map({ '@babylonjs/core/': '/modules/@babylonjs/core/' }) },
    argument: { count: all_attributes.length, workers },
    script: async ({ count, workers }) => {
      const { DracoDecoder } = await import('@babylonjs/core/Meshes/Compression/dracoDecoder.js');
      const { digest, fetch_bytes } = await import('/page.js');
      const decoder = new DracoDecoder({ numWorkers: workers, wasmUrl: '/psplit/draco/draco_wasm_wrapper.js',
        wasmBinaryUrl: '/psplit/draco/draco_decoder.wasm' });
      const answers = await Promise.all(Array.from({ length: count }, async (_, i) => {
        const mesh = await decoder.decodeMeshToMeshDataAsync(await fetch_bytes(`/${i}.drc`),
          { position: 0, normal: 1, uv: 2, color: 3 }, { color: true });
        return { points: mesh.totalVertices, indices: await digest(Uint32Array.from(mesh.indices)),
          attributes: Object.fromEntries(await Promise.all(
            mesh.attributes.map(async ({ kind, data }) => [kind, await digest(data)]))) };
      }));
      decoder.dispose();
      return answers;
    },
  }, async ({ result }) => {
    const answers = await result;
    assert.ok(answers.length === 20);
    for (const [i, [name, bytes]] of all_attributes.entries()) {
      const { pointCount, indices, attributes: [position, normal, uv, color] } = decode(bytes);
      assert.deepEqual(answers[i], { points: pointCount, indices: digest(indices), attributes: { position: digest(position.array),
        normal: digest(normal.array), uv: digest(uv.array), color: digest(color.array) } }, name);
    }
  });

page_test('model-viewer on psplit/draco', {
  skip: corpus_folder === null && 'there is no corpus',
  files: {
    ...(corpus_folder === null ? {} : { '/box.glb': { folder: path.join(corpus_folder, 'gltf/draco/Box_Draco.glb') } }),
    '/': '<!doctype html><script type="module" src="/main.js"></script><model-viewer loading="eager"></model-viewer>',
  },
  script: async () => {
    const { ModelViewerElement } = await import('/modules/@google/model-viewer/dist/model-viewer.min.js');
    ModelViewerElement.dracoDecoderLocation = '/psplit/draco/';
    const viewer = document.querySelector('model-viewer');
    await new Promise((resolve, reject) => {
      viewer.addEventListener('load', resolve);
      viewer.addEventListener('error', ({ detail }) => reject(new Error(JSON.stringify(detail))));
      viewer.src = '/box.glb';
    });
    const { x, y, z } = viewer.getDimensions();
    return [x, y, z].map((length) => length.toFixed(6));
  },
}, async ({ result, site }) => {
  assert.deepEqual(await result, ['1.000000', '1.000000', '1.000000']);
  assert.ok(site.requests.includes('/psplit/draco/draco_decoder.wasm'));
});
