// The decoders that bench.mjs measures. Each one decodes a mesh to arrays of indices and attributes:
//
//   { name, stored, create() }    `stored`: in which coding the mesh is stored
//   create() resolves to { run(primitive), memory? }, an instance of its own. run() may be asynchronous; memory() is the
//   bytes of its WebAssembly memory, of which psplit/draco gives back some when it is idle.
//
// A rival that npm does not have is a module that exports `name`, `code` (paths beside it) and decode(bytes, attributes), which
// returns { indices, arrays }.
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { BlobWorker } from '../../tests/web/blob_worker.mjs';
import { modules_folder, package_folder } from '../../tests/web/load.mjs';
import { code_of_page } from '../../tests/web/page_code.mjs';

const in_modules = (name) => path.join(modules_folder, 'node_modules', name);
const in_package = (name) => path.join(package_folder, name);
const require_module = createRequire(path.join(modules_folder, 'package.json'));
const load = (file) => import(pathToFileURL(file));
const { array_of } = await load(in_package('types.js'));
const { version: meshopt_version } = JSON.parse(readFileSync(in_modules('meshoptimizer/package.json'), 'utf8'));
const of_three = in_modules('three/examples/jsm/libs/draco/gltf/');

// By the calls that DRACOLoader makes.
function decode_by_interface(draco, { bytes, attributes }) {
  const decoder = new draco.Decoder(), mesh = new draco.Mesh();
  const status = decoder.DecodeArrayToMesh(new Int8Array(bytes.buffer, bytes.byteOffset, bytes.length), bytes.length, mesh);
  if (!status.ok()) throw new Error(status.error_msg());
  const copied = (size, write) => {
    const at = draco._malloc(size);
    write(size, at);
    const array = draco.HEAPU8.slice(at, at + size);
    draco._free(at);
    return array;
  };
  copied(12 * mesh.num_faces(), (size, at) => decoder.GetTrianglesUInt32Array(mesh, size, at));
  for (const { uniqueId, componentCount, type } of attributes)
    copied(array_of(type).BYTES_PER_ELEMENT * mesh.num_points() * componentCount, (size, at) => decoder.GetAttributeDataArrayForAllPoints(mesh,
      decoder.GetAttributeByUniqueId(mesh, uniqueId), draco[`DT_${type.toUpperCase()}`], size, at));
  draco.destroy(mesh);
  draco.destroy(decoder);
}

const by_interface = (name, create_module) => ({ name, stored: 'stock', async create() {
  const draco = await create_module();
  return { run: (primitive) => decode_by_interface(draco, primitive), memory: () => draco.HEAP8.length };
} });

// draco3d's script is a classic one, inside a package of modules.
const three_module = () => new Function('require', '__dirname',
  `${readFileSync(`${of_three}draco_wasm_wrapper.js`)}; return DracoDecoderModule;`)(createRequire(import.meta.url), of_three)(
  { wasmBinary: readFileSync(`${of_three}draco_decoder.wasm`) });

const by_instance = (name, stored, kind, wasm = 'psplit.wasm') => ({ name, stored, async create() {
  const [{ Instance }, { decode_alone }, { make_job }] = await Promise.all(['instance.js', 'container_job.js', 'job.js']
    .map((file) => load(in_package(file))));
  const instance = new Instance(await WebAssembly.compile(readFileSync(in_package(wasm))));
  return { memory: () => instance.memory_bytes, run({ bytes, attributes }) {
    const job = make_job(kind, bytes, { attributes });
    if (kind === 'draco') instance.decode_draco(job.bytes, job.attributes);
    else decode_alone(instance, job, () => {});
  } };
} });

const meshoptimizer = { name: `meshopt_decoder ${meshopt_version}`, stored: 'meshopt', async create() {
  const { MeshoptDecoder } = await load(in_modules('meshoptimizer/meshopt_decoder.mjs'));
  await MeshoptDecoder.ready;
  return { run({ index_count, point_count, indices, streams }) {
    MeshoptDecoder.decodeIndexBuffer(new Uint8Array(4 * index_count), index_count, 4, indices);
    for (const { bytes, stride, filter } of streams)
      MeshoptDecoder.decodeVertexBuffer(new Uint8Array(point_count * stride), point_count, stride, bytes, filter);
  } };
} };

const rivals_of = (files) => Promise.all(files.map(async (file) =>
  ({ ...await load(path.resolve(file)), folder: path.dirname(file) })));

/** Decoders on the calling thread. The first is what the others are compared with. */
export async function calling_thread(rival_files) {
  const of_files = (await rivals_of(rival_files)).map(({ name, decode }) => ({ name, stored: 'stock',
    create: async () => ({ run: ({ bytes, attributes }) => void decode(bytes, attributes) }) }));
  return [
    by_interface('draco3d 1.5.7', () => require_module('draco3d').createDecoderModule({})),
    by_interface('draco3d 1.5.9', () => require_module('draco3d-newest').createDecoderModule({})),
    by_interface("three's draco_decoder", three_module),
    ...of_files,
    by_interface('psplit/draco', () => require_module(in_package('draco/draco_wasm_wrapper.js'))()),
    by_instance('psplit, one stream', 'stock', 'draco'),
    by_instance('psplit, patches', 'patches', 'container'),
    by_instance('psplit, condensed', 'condensed', 'container', 'psplit_condensed.wasm'),
    meshoptimizer,
  ];
}

// three's DRACOLoader with one worker, as it decodes for GLTFLoader.
async function three_loader() {
  const server = createServer((request, response) => response.end(readFileSync(of_three + path.basename(request.url))));
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  globalThis.Worker = BlobWorker;
  globalThis.ProgressEvent ??= class extends Event {};
  globalThis.self ??= globalThis;
  const { DRACOLoader } = await load(in_modules('three/examples/jsm/loaders/DRACOLoader.js'));
  const loader = new DRACOLoader().setDecoderPath(`http://127.0.0.1:${server.address().port}/`).setWorkerLimit(1);
  return { loader, end() {
    loader.dispose();
    server.close();
  } };
}

const by_pool = (name, stored, workers, decode) => ({ name, stored, async create() {
  const { createPool } = await load(in_package('index.js'));
  const pool = createPool({ workers, shared: false, idleMs: 1e6 });
  return { run: ({ bytes, attributes }) => pool[decode](bytes, { attributes }), end: () => pool.dispose() };
} });

/** Decoders in workers. The first is what the others are compared with. */
export const in_workers = () => [
  { name: "three's DRACOLoader, 1 worker", stored: 'stock', async create() {
    const { loader, end } = await three_loader();
    return { end, run: ({ bytes, attributes }) => loader.decodeGeometry(bytes.slice().buffer, {
      attributeIDs: Object.fromEntries(attributes.map(({ name, uniqueId }) => [name, uniqueId])),
      attributeTypes: Object.fromEntries(attributes.map(({ name }) => [name, 'Float32Array'])), useUniqueIDs: true }) };
  } },
  by_pool('psplit, one stream, 1 worker', 'stock', 1, 'decodeDraco'),
  by_pool('psplit, patches, 1 worker', 'patches', 1, 'decodeContainer'),
  by_pool('psplit, patches, 2 workers', 'patches', 2, 'decodeContainer'),
  by_pool('psplit, condensed, 2 workers', 'condensed', 2, 'decodeContainer'),
];

/**
 * What a page loads, as [name, [texts and bytes]]. Files that a page has as they are are not changed; what bundlers make of the
 * rest of psplit's code is minified, without the loader's own.
 */
export async function code_of_pages(rival_files) {
  const files = (folder, ...names) => names.map((name) => readFileSync(path.join(folder, name)));
  const wasm = readFileSync(in_package('psplit.wasm')), worker = await code_of_page('worker.js');
  return [
    ['draco3d 1.5.7 (for Node.js)', files(in_modules('draco3d'), 'draco_decoder_nodejs.js', 'draco_decoder.wasm')],
    ['draco3d 1.5.9 (for Node.js)', files(in_modules('draco3d-newest'), 'draco_decoder_nodejs.js', 'draco_decoder.wasm')],
    ["three's draco_decoder", files(of_three, 'draco_wasm_wrapper.js', 'draco_decoder.wasm')],
    ...(await rivals_of(rival_files)).map(({ name, code, folder }) => [name, files(folder, ...code)]),
    [meshoptimizer.name, files(in_modules('meshoptimizer'), 'meshopt_decoder.mjs')],
    ['psplit/draco', files(in_package('draco'), 'draco_wasm_wrapper.js', 'draco_decoder.wasm')],
    ['psplit', [wasm, await code_of_page('index.js'), worker]],
    ['psplit/gltf, no workers', [wasm, await code_of_page('asset.js')]],
    ['psplit/three', [wasm, await code_of_page('three.js'), worker]],
    ['psplit/babylon', [wasm, await code_of_page('babylon.js'), worker]],
    ['psplit/inline', files(package_folder, 'inline.js')],
  ];
}

/** The same of encoders. */
export async function code_of_encoders() {
  const of = (folder, script) => ['draco_encoder.wasm', script].map((name) => readFileSync(path.join(folder, name)));
  return [['draco3d 1.5.7 (for Node.js)', of(in_modules('draco3d'), 'draco_encoder_nodejs.js')], ['psplit/draco', of(in_package('draco'), 'draco_encoder.js')],
    ['psplit/encode', [readFileSync(in_package('psplit_encoder.wasm')), await code_of_page('encode.js')]]];
}
