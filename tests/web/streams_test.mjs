// Draco streams decode to the arrays of stock Draco, to the bit; all but streams of bitstream 2.2 are refused.
import assert from 'node:assert/strict';
import test from 'node:test';
import { corpus_folder, corpus_streams, psplit } from './load.mjs';
import { decode, streams } from './stock_draco.mjs';

async function check(bytes, what) {
  const expected = decode(bytes), mesh = await psplit.decodeDraco(bytes);
  assert.equal(mesh.faceCount, expected.faceCount, what);
  assert.equal(mesh.pointCount, expected.pointCount, what);
  assert.deepEqual(mesh.indices, expected.indices, what);
  assert.equal(mesh.attributes.length, expected.attributes.length, what);
  expected.attributes.forEach(({ uniqueId, componentCount, array }, i) => {
    assert.equal(mesh.attributes[i].uniqueId, uniqueId, what);
    assert.equal(mesh.attributes[i].componentCount, componentCount, what);
    assert.equal(mesh.attributes[i].array.constructor, array.constructor, what);
    assert.ok(Buffer.from(mesh.attributes[i].array.buffer).equals(Buffer.from(array.buffer)), `${what}: attribute ${i}`);
  });
}

test('every coding of draco3d', async () => {
  let count = 0;
  for (const [name, bytes] of streams()) {
    await check(bytes, name);
    ++count;
  }
  assert.equal(count, 40);
});

test('the corpus', { skip: corpus_folder === null && 'there is no corpus' }, async () => {
  let same = 0, refused = 0;
  for (const [file, bytes] of corpus_streams()) {
    const [kind, major, minor] = [bytes[7], bytes[5], bytes[6]];
    if (kind === 1 && major === 2 && minor === 2) {
      await check(bytes, file);
      ++same;
    } else {
      const code = kind === 1 ? 'unsupported' : 'invalid-input';
      await assert.rejects(psplit.decodeDraco(bytes), { name: 'PsplitError', code }, file);
      ++refused;
    }
  }
  assert.ok(same > 20 && refused > 0, `${same} the same, ${refused} refused`);
});

test('attributes by unique id, in other types', async () => {
  const [[, bytes]] = [...streams()].filter(([name]) => name === 'edgebreaker, speed 5, 11 bits, more attributes');
  const whole = await psplit.decodeDraco(bytes);
  const [position, , , color, generic] = whole.attributes;
  const mesh = await psplit.decodeDraco(bytes, { attributes: [
    { uniqueId: generic.uniqueId, name: '_ID', type: 'float32' },
    { uniqueId: color.uniqueId, type: 'uint16' },
    { uniqueId: position.uniqueId },
  ] });
  assert.deepEqual(mesh.attributes.map(({ name }) => name), ['_ID', `attribute ${color.uniqueId}`, `attribute ${position.uniqueId}`]);
  assert.deepEqual(mesh.attributes[0].array, Float32Array.from(generic.array));
  assert.deepEqual(mesh.attributes[1].array, Uint16Array.from(color.array));
  assert.deepEqual(mesh.attributes[2].array, position.array);
  const wrong = (attributes, code) => assert.rejects(psplit.decodeDraco(bytes, { attributes }), { name: 'PsplitError', code });
  await wrong([{ uniqueId: 77 }], 'invalid-input');
  await wrong([{ uniqueId: generic.uniqueId, type: 'uint8' }], 'invalid-input');  // 13 * 400 does not fit
  await wrong([{ uniqueId: 0, type: 'text' }], 'invalid-input');
  await wrong('all', 'invalid-input');
});

test('data of any kind', async () => {
  const [[, bytes]] = streams();
  const expected = await psplit.decodeDraco(bytes);
  const larger = new Uint8Array(bytes.length + 9);
  larger.set(bytes, 5);
  for (const data of [bytes.buffer, new DataView(bytes.buffer), larger.subarray(5, 5 + bytes.length), Buffer.from(bytes)])
    assert.deepEqual((await psplit.decodeDraco(data)).indices, expected.indices);
  for (const data of [null, 'DRACO', [1, 2], 7]) await assert.rejects(psplit.decodeDraco(data), { name: 'PsplitError' });
  await assert.rejects(psplit.decodeDraco(new Uint8Array(0)), { name: 'PsplitError', code: 'invalid-input' });
});
