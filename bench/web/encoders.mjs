// Measures encoders of the web on the same meshes, in one process, in turn:
//
//   node encoders.mjs ROUNDS FACES [GLB...]   the tables of docs/measured/web.md, as Markdown; also of plain assets
//
// Each encoder has an instance of its own for each mesh, and builds the mesh and encodes it in each round. Times are medians of
// the rounds' CPU time, ratios medians of the rounds' ratios. The bytes have to be the same.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { brotliCompressSync } from 'node:zlib';
import { modules_folder, package_folder, stock } from '../../tests/web/load.mjs';
import { code_of_page } from '../../tests/web/page_code.mjs';
import { pathToFileURL } from 'node:url';
import { measured } from './cpu_time.mjs';

const [rounds, faces] = process.argv.slice(2, 4).map(Number), assets = process.argv.slice(4), kWarmUpRounds = 1;
const own = createRequire(import.meta.url)(path.join(package_folder, 'draco/draco_encoder.js'));
const encoders = [['draco3d 1.5.7', stock.createEncoderModule], ['psplit/draco', own.createEncoderModule]];
const median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];

// A grid of size x size squares that is bent, with normals and texture coordinates.
function grid(face_count, place) {
  const size = Math.round(Math.sqrt(face_count / 2)), row = size + 1, points = row * row;
  const positions = new Float32Array(3 * points), normals = new Float32Array(3 * points), texcoords = new Float32Array(2 * points);
  const faces = new Uint32Array(6 * size * size);
  for (let i = 0; i < points; ++i) {
    const u = (i % row) / size, v = Math.floor(i / row) / size, step = 1e-4;
    const at = place(u, v), along_u = place(u + step, v).map((value, k) => value - at[k]), along_v = place(u, v + step).map((value, k) => value - at[k]);
    const normal = [0, 1, 2].map((k) => along_u[(k + 1) % 3] * along_v[(k + 2) % 3] - along_u[(k + 2) % 3] * along_v[(k + 1) % 3]);
    positions.set(at, 3 * i);
    normals.set(normal.map((value) => value / (Math.hypot(...normal) || 1)), 3 * i);
    texcoords.set([u, v], 2 * i);
  }
  for (let square = 0, out = 0; square < size * size; ++square) {
    const at = square + Math.floor(square / size);
    for (const corner of [at, at + 1, at + row, at + 1, at + row + 1, at + row]) faces[out++] = corner;
  }
  return { faces, points, attributes: [['POSITION', 3, positions], ['NORMAL', 3, normals], ['TEX_COORD', 2, texcoords]] };
}
const terrain = (u, v) => [u, 0.05 * Math.sin(21 * u + 3 * Math.sin(9 * v)) + 0.02 * Math.cos(50 * v + 7 * u) + 0.0005 * Math.sin(3000 * u * v), v];
const shell = (u, v) => [Math.cos(6.2 * u) * (1 + 0.3 * Math.cos(6.2 * v)), Math.sin(6.2 * u) * (1 + 0.3 * Math.cos(6.2 * v)), 0.3 * Math.sin(6.2 * v) + 0.01 * Math.sin(90 * u)];
const only = (mesh, count) => ({ ...mesh, attributes: mesh.attributes.slice(0, count) });
const meshes = { small: grid(5000, shell), shell: only(grid(faces, shell), 1), 'shell with normals': only(grid(faces, shell), 2), terrain: grid(faces, terrain) };

function encode(draco, mesh, speed) {
  const encoder = new draco.Encoder(), builder = new draco.MeshBuilder(), to = new draco.Mesh(), out = new draco.DracoInt8Array();
  for (const [semantic, components, values] of mesh.attributes) builder.AddFloatAttribute(to, draco[semantic], mesh.points, components, values);
  builder.AddFacesToMesh(to, mesh.faces.length / 3, mesh.faces);
  for (const [semantic, bits] of [['POSITION', 14], ['NORMAL', 10], ['TEX_COORD', 12]]) encoder.SetAttributeQuantization(draco[semantic], bits);
  encoder.SetSpeedOptions(speed, speed);
  encoder.EncodeMeshToDracoBuffer(to, out);
  for (const object of [encoder, builder, to]) draco.destroy(object);
  return out;
}
// As exporters do, value by value. It is not measured.
function bytes_of(draco, out) {
  const bytes = Buffer.from(Int8Array.from({ length: out.size() }, (_, i) => out.GetValue(i)).buffer);
  draco.destroy(out);
  return bytes;
}

console.log('| mesh | speed | bytes | draco3d, CPU ms | psplit, CPU ms | times | draco3d, heap MiB | psplit, heap MiB | of draco3d |');
console.log('|---|---:|---:|---:|---:|---:|---:|---:|---:|');
for (const [name, mesh] of Object.entries(meshes))
  for (const speed of [0, 3, 5, 7, 10]) {
    const modules = [], times = [[], []], runs = Math.max(1, Math.round(50000 / (mesh.faces.length / 3)));
    for (const [, create] of encoders) modules.push(await create({}));
    let bytes;
    for (let round = -kWarmUpRounds; round < rounds; ++round) {
      const streams = [];
      for (const [i, draco] of modules.entries()) {
        let out;
        const { all } = await measured(async () => {
          for (let left = runs; left > 0; --left) {
            if (out !== undefined) draco.destroy(out);
            out = encode(draco, mesh, speed);
          }
        });
        if (round >= 0) times[i].push(all / runs);
        streams.push(bytes_of(draco, out));
      }
      if (!streams[0].equals(streams[1])) throw new Error(`${name}, speed ${speed}: the streams differ`);
      bytes = streams[0].length;
    }
    const heaps = modules.map(({ HEAPU8 }) => HEAPU8.length / 2 ** 20), ratio = median(times[0].map((time, i) => time / times[1][i]));
    console.log(`| ${name}: ${(mesh.faces.length / 3).toLocaleString('en-US')} faces, ${mesh.attributes.map(([semantic]) => semantic).join(', ')} | ${speed} | ${
      bytes.toLocaleString('en-US')} | ${times.map((of) => median(of).toFixed(1)).join(' | ')} | ${ratio.toFixed(2)} | ${
      heaps.map((heap) => heap.toFixed(1)).join(' | ')} | ${(heaps[1] / heaps[0]).toFixed(2)} |`);
  }

// Containers: psplit/encode beside draco3d, which makes one stream. An instance of psplit/encode lives for one mesh.
const { encodeMesh } = await import(pathToFileURL(path.join(package_folder, 'encode.js')));
const { decodeGlb } = await import(pathToFileURL(path.join(package_folder, 'asset.js')));
const kNames = { POSITION: 'POSITION', NORMAL: 'NORMAL', TEX_COORD: 'TEXCOORD_0' };
const kWays = [['patches', {}], ['not verified', { verify: false }], ['condensed', { condense: true }]];
const of_assets = await Promise.all(assets.map(async (file) => {
  const { primitives: [{ indices, attributes, pointCount: points }] } = await decodeGlb(readFileSync(file));
  const known = Object.entries(kNames).filter(([, name]) => name in attributes);
  return [path.basename(file).replace(/\..*/, ''), { faces: Uint32Array.from(indices), points,
    attributes: known.map(([semantic, name]) => [semantic, attributes[name].componentCount, attributes[name].array]) }];
}));
console.log(`\n| mesh | draco3d, bytes | CPU ms | ${kWays.map(([way]) => `${way}, bytes | CPU ms | times`).join(' | ')} |`);
console.log(`|---|---:|---:|${kWays.map(() => '---:|---:|---:|').join('')}`);
for (const [name, mesh] of [...Object.entries(meshes), ...of_assets]) {
  const draco = await stock.createEncoderModule({}), times = [[], ...kWays.map(() => [])], bytes = [];
  const given = { indices: mesh.faces, attributes: Object.fromEntries(mesh.attributes.map(([semantic, componentCount, array]) =>
    [kNames[semantic], { array, componentCount }])) };
  for (let round = -kWarmUpRounds; round < rounds; ++round)
    for (const [i, way] of [undefined, ...kWays].entries()) {
      let out;
      const { all } = await measured(async () => { out = way === undefined ? encode(draco, mesh, 5) : await encodeMesh(given, way[1]); });
      if (round >= 0) times[i].push(all);
      bytes[i] = way === undefined ? bytes_of(draco, out).length : out.container.length;
    }
  const ratio = (i) => median(times[0].map((time, round) => time / times[i][round])).toFixed(2);
  console.log(`| ${name}: ${(mesh.faces.length / 3).toLocaleString('en-US')} faces, ${mesh.attributes.map(([semantic]) => semantic).join(', ')} | ${
    bytes.map((count, i) => `${count.toLocaleString('en-US')} | ${median(times[i]).toFixed(0)}${i > 0 ? ` | ${ratio(i)}` : ''}`).join(' | ')} |`);
}

console.log('\n| encoder | module, bytes | module, brotli | script, brotli |\n|---|---:|---:|---:|');
const of_draco3d = path.join(modules_folder, 'node_modules/draco3d'), of_psplit = path.join(package_folder, 'draco');
for (const [name, folder, script] of [['draco3d 1.5.7 (for Node.js)', of_draco3d, 'draco_encoder_nodejs.js'], ['psplit/draco', of_psplit, 'draco_encoder.js']]) {
  const read = (file) => readFileSync(path.join(folder, file)), brotli = (file) => brotliCompressSync(read(file)).length.toLocaleString('en-US');
  console.log(`| ${name} | ${read('draco_encoder.wasm').length.toLocaleString('en-US')} | ${brotli('draco_encoder.wasm')} | ${brotli(script)} |`);
}
const encoder = readFileSync(path.join(package_folder, 'psplit_encoder.wasm'));
console.log(`| psplit/encode | ${encoder.length.toLocaleString('en-US')} | ${brotliCompressSync(encoder).length.toLocaleString('en-US')} | ${
  brotliCompressSync(await code_of_page('encode.js')).length.toLocaleString('en-US')}, minified |`);
