// Containers decode to the arrays of gltf-psplit, whose hashes the extension's samples name.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { compressed_primitives, psplit, root } from './load.mjs';

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const expected = JSON.parse(readFileSync(path.join(samples, 'expected.json')));
const hash = (array) => createHash('sha256').update(new Uint8Array(array.buffer, array.byteOffset, array.byteLength)).digest('hex');

for (const [name, { primitives }] of Object.entries(expected))
  test(`sample ${name}`, async () => {
    const found = compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches');
    assert.equal(found.length, primitives.length);
    for (const [i, { bytes, attributes }] of found.entries()) {
      const mesh = await psplit.decodeContainer(bytes, { attributes });
      assert.equal(mesh.pointCount, primitives[i].points);
      assert.equal(mesh.indices.length, primitives[i].indices);
      assert.equal(hash(mesh.indices), primitives[i].indices_sha256);
      assert.deepEqual(Object.fromEntries(mesh.attributes.map(({ name, array }) => [name, hash(array)])),
        { ...primitives[i].attributes_sha256, ...primitives[i].targets_sha256 });
    }
  });

test('containers with Draco streams and with condensed streams are among the samples', async () => {
  const found = new Set();
  for (const name of Object.keys(expected))
    for (const { bytes, attributes } of compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches'))
      found.add((await psplit.decodeContainer(bytes, { attributes })).isCondensed);
  assert.deepEqual([...found].sort(), [false, true]);
});

test('errors name the patch', async () => {
  const [{ bytes, attributes }] = compressed_primitives(path.join(samples, 'patches.glb'), 'PSPLIT_mesh_draco_patches');
  const broken = Uint8Array.from(bytes);
  broken.fill(0xff, bytes.length - 60);
  await assert.rejects(psplit.decodeContainer(broken, { attributes }), (error) => {
    assert.equal(error.code, 'invalid-input');
    assert.ok(error.patch > 0);
    assert.match(error.message, new RegExp(`^patch ${error.patch}: Draco stream: `));
    return true;
  });
  const cut = psplit.decodeContainer(bytes.subarray(0, bytes.length - 1), { attributes });
  await assert.rejects(cut, { code: 'invalid-input', patch: undefined, message: 'container: its length is not the sum of its parts' });
  await assert.rejects(psplit.decodeContainer(bytes, { attributes: [{ ...attributes[0], uniqueId: 9 }] }),
    { code: 'invalid-input', message: 'patch 0: Draco stream: no attribute for POSITION (unique id 9)' });
  const newer = Uint8Array.from(bytes);
  newer[4] = 99;
  await assert.rejects(psplit.decodeContainer(newer, { attributes }), { code: 'unsupported' });
  await assert.rejects(psplit.decodeContainer(bytes, { attributes: 'all' }), { code: 'invalid-input' });
});

test('all attributes, if none are named', async () => {
  for (const name of Object.keys(expected))
    for (const { bytes, attributes } of compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches')) {
      const mesh = await psplit.decodeContainer(bytes);
      const named = await psplit.decodeContainer(bytes, { attributes });
      assert.deepEqual(mesh.indices, named.indices);
      assert.deepEqual(mesh.attributes.map(({ uniqueId }) => uniqueId).sort(), attributes.map(({ uniqueId }) => uniqueId).sort());
      for (const { name, uniqueId, type, array } of mesh.attributes) {
        const same = named.attributes.find((attribute) => attribute.uniqueId === uniqueId);
        assert.ok(same.name.replace('TEXCOORD', 'TEX_COORD').startsWith(name) || name === 'GENERIC', `${same.name} as ${name}`);
        assert.equal(type, same.type);
        assert.deepEqual(array, same.array);
      }
    }
});

test('patches are slices of the mesh', async () => {
  const [{ bytes, attributes }] = compressed_primitives(path.join(samples, 'residue.glb'), 'PSPLIT_mesh_draco_patches');
  const { faceCount, pointCount, patchCount, hasResidue, firstFaces, firstPoints } = await psplit.decodeContainer(bytes, { attributes });
  assert.ok(hasResidue && patchCount > 1);
  for (const [firsts, count] of [[firstFaces, faceCount], [firstPoints, pointCount]]) {
    assert.equal(firsts.length, patchCount + 2);
    assert.ok(firsts[0] === 0 && firsts.every((first, i) => i === 0 || first >= firsts[i - 1]));
    assert.equal(firsts.at(-1), count);
  }
});
