// Positions and texture coordinates on grids of more than 14 bits, and edges as long as the grid: the same values as the native
// decoder's, for Draco's and condensed streams.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import test from 'node:test';
import { compressed_primitives, gltf_psplit, psplit, read_asset } from './load.mjs';

const kColumns = 14, kRows = 11;

// A number in [0, 1]; a third of them are 0, a third are 1.
function ends(state) {
  const random = Math.imul(state + 1, 0x9e3779b1) >>> 0;
  return Math.min(1, Math.max(0, (random / 2 ** 32) * 3 - 1));
}

// A sheet whose points are anywhere, as glTF with its data in the JSON.
function long_edges() {
  const points = (kColumns + 1) * (kRows + 1);
  const positions = Float32Array.from({ length: 3 * points }, (_, i) => ends(i));
  const texcoords = Float32Array.from({ length: 2 * points }, (_, i) => ends(i + 100000));
  const indices = [];
  for (let y = 0; y < kRows; y++)
    for (let x = 0; x < kColumns; x++) {
      const a = y * (kColumns + 1) + x;
      indices.push(a, a + 1, a + kColumns + 2, a, a + kColumns + 2, a + kColumns + 1);
    }
  const parts = [positions, texcoords, Uint16Array.from(indices)].map(({ buffer }) => Buffer.from(buffer));
  let byteOffset = 0;
  const bufferViews = parts.map(({ length }) => ({ buffer: 0, byteLength: length, byteOffset: (byteOffset += length) - length }));
  return {
    asset: { version: '2.0' },
    buffers: [{ byteLength: byteOffset, uri: `data:application/octet-stream;base64,${Buffer.concat(parts).toString('base64')}` }],
    bufferViews,
    accessors: [
      { bufferView: 0, componentType: 5126, type: 'VEC3', count: points, min: [0, 0, 0], max: [1, 1, 1] },
      { bufferView: 1, componentType: 5126, type: 'VEC2', count: points },
      { bufferView: 2, componentType: 5123, type: 'SCALAR', count: indices.length },
    ],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2 }] }],
    nodes: [{ mesh: 0 }],
    scenes: [{ nodes: [0] }],
  };
}

// The bytes of an accessor that is packed tightly.
function accessor_bytes({ json, view_bytes }, index) {
  const { bufferView, byteOffset = 0, count, type } = json.accessors[index];
  const bytes = view_bytes(bufferView).subarray(byteOffset, byteOffset + count * 4 * { VEC2: 2, VEC3: 3 }[type]);
  return Buffer.from(bytes);
}

test('fine grids', { skip: gltf_psplit === null && 'there is no gltf-psplit' }, async (t) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'psplit-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const file = (name) => path.join(folder, name);
  writeFileSync(file('plain.gltf'), JSON.stringify(long_edges()));
  for (const bits of [15, 18, 19, 20, 24])
    for (const speed of [0, 2, 5, 10])
      for (const options of [[], ['--condense']]) {
        const name = `${bits} bits, speed ${speed}, ${options}`;
        if (bits > 20 && speed < 2) continue; // libdraco's encoder counts symbols in tables of 2^bits entries
        execFileSync(gltf_psplit, ['encode', file('plain.gltf'), file('patches.glb'), '--patches', '3', '--always-patches', '-q',
          '--quantize-position', bits, '--quantize-texcoord', bits, '--encode-speed', speed, ...options]);
        execFileSync(gltf_psplit, ['decode', file('patches.glb'), file('decoded.glb'), '-q']);
        const [{ bytes, attributes }] = compressed_primitives(file('patches.glb'), 'PSPLIT_mesh_draco_patches');
        const mesh = await psplit.decodeContainer(bytes, { attributes });
        const native = read_asset(file('decoded.glb')), { primitives: [primitive] } = native.json.meshes[0];
        for (const { name: semantic, array } of mesh.attributes)
          assert.deepEqual(Buffer.from(array.buffer, array.byteOffset, array.byteLength),
            accessor_bytes(native, primitive.attributes[semantic]), `${name}: ${semantic}`);
      }
});
