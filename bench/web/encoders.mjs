// Measures encoders of the web on the same meshes, in one process, in turn:  node encoders.mjs ROUNDS FACES
//
// Prints a line of JSON for each mesh and speed, which scripts/web-bench makes a table of. psplit/draco has to write draco3d's bytes. At
// speed 5, psplit/encode makes containers as well. Each encoder of streams has an instance of its own for each mesh, and builds the mesh
// and encodes it in each round; an instance of psplit/encode lives for one mesh.
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { package_folder, stock } from '../../tests/web/load.mjs';
import { measured } from './cpu_time.mjs';

const [rounds, faces] = process.argv.slice(2).map(Number), kWarmUpRounds = 1;
const own = createRequire(import.meta.url)(path.join(package_folder, 'draco/draco_encoder.js'));
const { encodeMesh } = await import(pathToFileURL(path.join(package_folder, 'encode.js')));

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
const meshes = { small: grid(5000, shell), shell: only(grid(faces, shell), 1), terrain: grid(faces, terrain) };

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

// The attributes of psplit/encode.
const kNames = { POSITION: 'POSITION', NORMAL: 'NORMAL', TEX_COORD: 'TEXCOORD_0' };
const kContainers = { patches: {}, condensed: { condense: true } };
for (const [name, mesh] of Object.entries(meshes))
  for (const speed of name === 'terrain' ? [0, 5] : [5]) {
    const modules = { draco3d: await stock.createEncoderModule({}), 'psplit/draco': await own.createEncoderModule({}) };
    const ways = [...Object.keys(modules), ...(speed === 5 ? Object.keys(kContainers) : [])], ms = ways.map(() => []), bytes = {}, heap = {};
    const attributes = mesh.attributes.map(([semantic, componentCount, array]) => [kNames[semantic], { array, componentCount }]);
    const given = { indices: mesh.faces, attributes: Object.fromEntries(attributes) };
    const runs = Math.max(1, Math.round(50000 / (mesh.faces.length / 3)));
    for (let round = -kWarmUpRounds; round < rounds; ++round)
      for (const [i, way] of ways.entries()) {
        let out;
        const draco = modules[way], { all } = await measured(async () => {
          for (let left = runs; left > 0; --left) {
            if (draco === undefined) {
              out = (await encodeMesh(given, kContainers[way])).container;
            } else {
              if (out !== undefined) draco.destroy(out);
              out = encode(draco, mesh, speed);
            }
          }
        });
        if (round >= 0) ms[i].push(all / runs);
        // psplit/draco gives memory back.
        if (draco !== undefined) heap[way] = Math.max(heap[way] ?? 0, draco.HEAPU8.length);
        bytes[way] = draco === undefined ? out : bytes_of(draco, out);
      }
    if (!bytes.draco3d.equals(bytes['psplit/draco'])) throw new Error(`${name}, speed ${speed}: the streams differ`);
    console.log(JSON.stringify({ what: 'encoders', name, faces: mesh.faces.length / 3, attributes: mesh.attributes.map(([semantic]) => semantic), speed,
      encoders: Object.fromEntries(ways.map((way, i) => [way, { ms: ms[i], bytes: bytes[way].length, heap: heap[way] }])) }));
  }
