// CPU time of decoders of the web on the same meshes, in one process, taken in turn:  node bench.mjs FOLDER ROUNDS
//
// Each decoder has an instance of its own. Its first call is the row "first": it has the time of compiling code while it
// runs. The others are medians of the rounds after it.
import { readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, modules_folder, package_folder, stock } from '../../tests/web/load.mjs';

const [folder, rounds] = [process.argv[2], Number(process.argv[3])];
const { Instance } = await import(pathToFileURL(path.join(package_folder, 'instance.js')));
const drop_in = createRequire(import.meta.url)(path.join(package_folder, 'draco/draco_wasm_wrapper.js'));
const of_three = path.join(modules_folder, 'node_modules/three/examples/jsm/libs/draco/gltf/');
const module = await WebAssembly.compile(readFileSync(path.join(package_folder, 'psplit.wasm')));

// A classic script inside a package of modules.
const of_three_script = new Function('require', '__dirname',
  `${readFileSync(path.join(of_three, 'draco_wasm_wrapper.js'))}; return DracoDecoderModule;`);

// As DRACOLoader decodes: three floats and so on, by calls of draco3d's interface.
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
  for (const { uniqueId, componentCount } of attributes)
    copied(4 * mesh.num_points() * componentCount, (size, at) => decoder.GetAttributeDataArrayForAllPoints(mesh,
      decoder.GetAttributeByUniqueId(mesh, uniqueId), draco.DT_FLOAT32, size, at));
  draco.destroy(mesh);
  draco.destroy(decoder);
}

const primitive = (name, kind, extension) => compressed_primitives(path.join(folder, `${name}.${kind}.glb`), extension)[0];
async function decoders_of(name) {
  const whole = primitive(name, 'stock', 'KHR_draco_mesh_compression');
  const decoders = {};
  const by_interface = async (label, create) => {
    const draco = await create();
    decoders[label] = { run: () => decode_by_interface(draco, whole), bytes: whole.bytes.length, memory: () => draco.HEAP8.length };
  };
  await by_interface('draco3d', () => stock.createDecoderModule({}));
  await by_interface("three's draco_decoder", () => of_three_script(createRequire(import.meta.url), of_three)(
    { wasmBinary: readFileSync(`${of_three}draco_decoder.wasm`) }));
  await by_interface('psplit, drop-in', drop_in);
  const by_package = (label, { bytes, attributes }, decode) => {
    const instance = new Instance(module);
    decoders[label] = { run: () => instance[decode](bytes, attributes), bytes: bytes.length, memory: () => instance.memory_bytes };
  };
  by_package('psplit, one stream', whole, 'decode_draco');
  if (primitive(name, 'patches', 'PSPLIT_mesh_draco_patches') !== undefined) {
    by_package('psplit, patches', primitive(name, 'patches', 'PSPLIT_mesh_draco_patches'), 'decode_container');
    by_package('psplit, condensed', primitive(name, 'condensed', 'PSPLIT_mesh_draco_patches'), 'decode_container');
  }
  return decoders;
}

const median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];
function timed(run) {
  const start = process.cpuUsage();
  run();
  const { user, system } = process.cpuUsage(start);
  return (user + system) / 1000;
}

for (const name of ['small', 'blob', 'gyroid', 'terrain'].filter((name) => readdirSync(folder).includes(`${name}.stock.glb`))) {
  const decoders = await decoders_of(name), times = {};
  for (let round = 0; round <= rounds; ++round)
    for (const [label, { run }] of Object.entries(decoders)) (times[label] ??= []).push(timed(run));
  const of_rival = times.draco3d.slice(1);
  console.log(`${name}: ms of CPU time, times as fast as draco3d (median of the rounds' ratios)`);
  console.log(`${''.padEnd(24)}${'first'.padStart(10)}${'warm'.padStart(10)}${'ratio'.padStart(8)}${'bytes'.padStart(12)}${'memory MiB'.padStart(12)}`);
  for (const [label, { bytes, memory }] of Object.entries(decoders)) {
    const [first, ...warm] = times[label];
    const ratio = median(warm.map((time, i) => of_rival[i] / time));
    console.log(label.padEnd(24) + first.toFixed(1).padStart(10) + median(warm).toFixed(1).padStart(10) + ratio.toFixed(2).padStart(8) +
      String(bytes).padStart(12) + (memory() / 2 ** 20).toFixed(1).padStart(12));
  }
}
