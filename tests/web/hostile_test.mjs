// Broken streams and containers are refused or decoded. The module is one that checks every index of the decoder, and
// ends at the first that is out of bounds. It has 32-bit sizes, so that products of counts that wrap would show.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { checked_module, compressed_primitives, package_folder, random_numbers, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const { Decoder } = await import(pathToFileURL(path.join(package_folder, 'instance.js')));
const { planned } = await import(pathToFileURL(path.join(package_folder, 'choice.js')));
const checked = await WebAssembly.compile(readFileSync(checked_module));
const decoder = new Decoder(checked), team = [0, 1, 2].map(() => new Decoder(checked));

const below = random_numbers(17);

// Changes a few bytes, mostly near the front, where the counts are; sometimes cuts or repeats a piece.
function mutate(bytes) {
  const kind = below(8);
  if (kind === 0) return bytes.slice(0, below(bytes.length));
  const mutant = Uint8Array.from(bytes);
  if (kind === 1) {
    const at = below(bytes.length), length = below(bytes.length - at);
    mutant.copyWithin(below(bytes.length - length), at, at + length);
    return mutant;
  }
  const reach = kind < 5 ? Math.min(100, bytes.length) : bytes.length;
  for (let left = 1 + below(4); left > 0; --left)
    mutant[below(reach)] = kind === 2 ? [0, 1, 0x7f, 0x80, 0xff][below(5)] : below(256);
  return mutant;
}

function run(kind, attributes, originals, count) {
  let refused = 0, decoded = 0;
  for (let i = 0; i < count; ++i) {
    try {
      decoder.run({ kind, bytes: mutate(originals[i % originals.length]), attributes });
      ++decoded;
    } catch (error) {
      assert.equal(error.name, 'PsplitError', error.stack);
      assert.ok(['invalid-input', 'unsupported'].includes(error.code), `mutant ${i}: ${error.message}`);
      ++refused;
    }
  }
  assert.ok(refused > count / 10 && decoded > 0, `${refused} refused, ${decoded} decoded`);
}

test('7,000 mutants of streams', () => run('draco', undefined, [...streams()].map(([, bytes]) => bytes), 7000));

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
for (const name of ['patches.glb', 'residue.glb', 'condensed.glb', 'condensed-speed-0.glb', 'condensed-lossless.glb'])
  test(`500 mutants of ${name}`, () => {
    const [{ bytes, attributes }] = compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches');
    run('container', attributes, [bytes], 500);
  });

// Decodes as the workers of a pool do, but in one thread.
async function decode_in_parts(bytes, attributes, part_count, is_shared) {
  const channels = Array.from({ length: part_count - 1 }, () => new MessageChannel());
  const results = await Promise.allSettled(team.slice(0, part_count).map((member, part) => member.run_part({
    kind: 'container', bytes, attributes, part, part_count, is_shared,
    ports: part === 0 ? channels.map(({ port1 }) => port1) : [channels[part - 1].port2] })));
  assert.ok(results.slice(1).every(({ status, value }) => status === 'fulfilled' && value === undefined));
  if (results[0].status === 'rejected') throw results[0].reason;
  return results[0].value;
}
// The result, or the error as data.
async function outcome(run) {
  try {
    const { indices, attributes, ...rest } = await run();
    return { ...rest, arrays: [indices, ...attributes.map(({ array }) => array)].map((array) => array.constructor.from(array)) };
  } catch ({ name, code, patch, message }) {
    return { name, code, patch, message };
  }
}

for (const name of ['patches.glb', 'residue.glb', 'condensed.glb', 'condensed-borders.glb', 'condensed-residue.glb'])
  test(`200 mutants of ${name} in several parts`, { timeout: 120000 }, async () => {
    const [{ bytes, attributes }] = compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches');
    let refused = 0, of_patches = 0;
    for (let i = 0; i < 200; ++i) {
      const mutant = i === 0 ? bytes : mutate(bytes);
      const expected = await outcome(() => decoder.run({ kind: 'container', bytes: mutant, attributes }));
      refused += expected.code !== undefined;
      of_patches += expected.patch !== undefined;
      assert.deepEqual(await outcome(() => decode_in_parts(mutant, attributes, 2 + (i % 2), i % 4 > 1)), expected, `mutant ${i}`);
    }
    assert.ok(refused > 20 && refused < 200 && of_patches > 0, `${refused} refused, ${of_patches} for a patch`);
  });

// Decodes some patches as decodeUrl does, in one thread. `is_late`: before more bytes are looked at, whether there are some.
async function decode_chosen(bytes, attributes, chosen, is_late) {
  const file = { bytes: async (begin, end) => bytes.slice(begin, end) }, { signal } = new AbortController();
  const plan = await planned(async () => checked, { file, begin: 0, end: bytes.length }, ({ patchCount }) => chosen.map((patch) => patch % patchCount), () => {}, signal);
  const chunks = [];
  for await (const part of plan.parts) chunks.push(part);
  const inbox = { next: async () => chunks.shift() ?? null, get has_more() { return chunks.length > 0 && is_late(); } };
  return decoder.run_part({ kind: 'container', arrives: true, attributes, chosen: plan.chosen }, () => {}, inbox);
}
for (const name of ['patches.glb', 'residue.glb', 'condensed.glb', 'condensed-borders.glb', 'condensed-residue.glb'])
  test(`500 mutants of ${name}, of which patches are chosen`, async () => {
    const [{ bytes, attributes }] = compressed_primitives(path.join(samples, name), 'PSPLIT_mesh_draco_patches');
    const { patchCount } = decoder.run({ kind: 'container', bytes, attributes }), chosen = Array.from({ length: patchCount }, (_, i) => patchCount - 1 - i);
    const alone = await decode_chosen(bytes, attributes, chosen, () => false);
    for (let i = 0; i < 20; ++i) assert.deepEqual(await decode_chosen(bytes, attributes, chosen, () => i === 0 || below(3) > 0), alone);
    let refused = 0;
    for (let i = 0; i < 500; ++i) {
      try {
        await decode_chosen(mutate(bytes), attributes, chosen, () => below(2) === 0);
      } catch (error) {
        assert.equal(error.name, 'PsplitError', error.stack);
        assert.ok(['invalid-input', 'unsupported'].includes(error.code), `mutant ${i}: ${error.message}`);
        ++refused;
      }
    }
    assert.ok(refused > 50 && refused < 500, `${refused} refused`);
  });
