// Is the specification sufficient? The decoder that was written from it (page_decoder.mjs) must decode to the same bytes as
// gltf-psplit, and refuse what gltf-psplit refuses:
//
//   node decode_test.mjs GLTF_PSPLIT MODULES SAMPLES
//
// MODULES is the folder where npm installed tests/validator, SAMPLES the folder of the extension's samples.
import { execFileSync, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { check, finish } from '../../support/checks.mjs';
import { accessor_bytes, accessor_indices, decode_container, decode_primitive, Invalid, parse_asset } from './page_decoder.mjs';

const [psplit, modules, samples] = process.argv.slice(2).map((argument) => path.resolve(argument));
const draco = await createRequire(path.join(modules, 'package.json'))('draco3d').createDecoderModule({});
const scratch = mkdtempSync(path.join(tmpdir(), 'psplit-page-'));
process.on('exit', () => rmSync(scratch, { recursive: true, force: true }));
const run = (...words) => execFileSync(psplit, words.map(String), { stdio: ['ignore', 'pipe', 'inherit'] });
const in_scratch = (name) => path.join(scratch, name);

function load(file) {
  return parse_asset(new Uint8Array(readFileSync(file)), (uri) =>
    new Uint8Array(uri.startsWith('data:') ? Buffer.from(uri.split(',')[1], 'base64')
      : readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))));
}
const primitives_of = (asset) => asset.json.meshes.flatMap(
  (mesh) => mesh.extensions?.PSPLIT_mesh_draco_patches?.primitives ?? mesh.primitives);
const sha256 = (bytes) => createHash('sha256').update(bytes).digest('hex');
const same = (a, b) => Buffer.compare(Buffer.from(a.buffer, a.byteOffset, a.byteLength),
  Buffer.from(b.buffer, b.byteOffset, b.byteLength)) === 0;

// Decodes every primitive of an asset with the page's decoder and with gltf-psplit. The features of the format that it uses
// are counted in `uses`.
const uses = {};
function compare(file, expected) {
  const name = path.basename(file), asset = load(file);
  run('decode', '-q', file, in_scratch('plain.glb'));
  const plain = load(in_scratch('plain.glb')), plain_primitives = primitives_of(plain);
  let any = false;
  primitives_of(asset).forEach((primitive, i) => {
    const what = `${name}, primitive ${i}`;
    if (!primitive.extensions?.PSPLIT_mesh_draco_patches) return;
    any = true;
    const mesh = decode_primitive(draco, asset, primitive);
    for (const [use, count] of Object.entries(mesh.uses)) uses[use] = (uses[use] ?? 0) + Number(count);
    const decoded = plain_primitives[i];
    check(!mesh.uses.unequal_copies, `${what}: copies of a point differ`);
    check(same(mesh.indices, accessor_indices(plain, decoded.indices)), `${what}: other indices`);
    for (const [semantic, values] of Object.entries(mesh.attributes)) {
      const { count } = asset.json.accessors[primitive.attributes[semantic]];
      check(count === mesh.points, `${what}: count of ${semantic}`);
      const wanted = accessor_bytes(plain, decoded.attributes[semantic]);
      check(same(values, wanted), `${what}: other values of ${semantic}`);
    }
    mesh.targets.forEach((target, t) => {
      for (const [semantic, values] of Object.entries(target)) {
        uses.targets = (uses.targets ?? 0) + 1;
        check(same(values, accessor_bytes(plain, decoded.targets[t][semantic])), `${what}: target ${t}: other ${semantic}`);
      }
    });
    if (asset.json.accessors[primitive.indices].bufferView !== undefined) {
      uses.fallbacks = (uses.fallbacks ?? 0) + 1;
      const indices = accessor_indices(asset, primitive.indices);
      check(same(mesh.indices, indices), `${what}: other indices in the fallback`);
      for (const [semantic, values] of Object.entries(mesh.attributes)) {
        const fallback = accessor_bytes(asset, primitive.attributes[semantic]);
        check(same(values, fallback), `${what}: other values of ${semantic} in the fallback`);
      }
    }
    if (expected === undefined) return;
    const is = { points: mesh.points, indices: mesh.indices.length,
      indices_sha256: sha256(new Uint8Array(mesh.indices.buffer)),
      attributes_sha256: Object.fromEntries(Object.entries(mesh.attributes).sort().map(([k, v]) => [k, sha256(v)])) };
    const targets = mesh.targets.flatMap((target, t) =>
      Object.entries(target).map(([k, v]) => [`targets/${t}/${k}`, sha256(v)]));
    if (targets.length > 0) is.targets_sha256 = Object.fromEntries(targets.sort());
    check(JSON.stringify(is) === JSON.stringify(expected.primitives[i]), `${what}: not what expected.json says`);
  });
  check(any, `${name}: no primitive with patches`);
  check(expected === undefined || expected.primitives.length === primitives_of(asset).length, `${name}: primitives`);
}

const expected = JSON.parse(readFileSync(path.join(samples, 'expected.json'), 'utf8'));
for (const name of Object.keys(expected)) compare(path.join(samples, name), expected[name]);

// The page's own examples: each dump decodes to the mesh on the page, and the tables explain the bytes of the dump.
{
  const page = readFileSync(path.join(samples, '..', 'README.md'), 'utf8');
  const from_hex = (text) => Buffer.from(text.replace(/[^0-9a-f]/g, ''), 'hex');
  const quoted = (cell, digits) => [...cell.matchAll(new RegExp(`\`(${digits}+)\``, 'g'))].map(([, text]) => text);
  const to_bits = (bytes) => [...bytes].map((byte) => byte.toString(2).padStart(8, '0').split('').reverse().join('')).join('');
  const examples = page.slice(page.indexOf('### Example\n')).split('### Example with condensed streams\n');
  const dumps = examples.map((text) =>
    from_hex([...text.matchAll(/^[0-9a-f]{2}  ((?:[0-9a-f]{2} ?)+)$/gm)].map((line) => line[1]).join('')));
  [20 + 7 + 5 + 79, 20 + 7 + 2 + 5 + 5 + 10].forEach((wanted, i) => {
    const dump = dumps[i], what = `example ${i + 1}`;
    const mesh = decode_container(draco, new Uint8Array(dump), [{ id: 0, componentType: 5126, components: 3 }]);
    check(mesh.points === 6 && mesh.indices.join(' ') === '0 1 2 1 3 2 4 0 2 3 5 4', `${what} decodes to another mesh`);
    check(mesh.uses.runs === 1 && mesh.uses.repeats === 1 && mesh.uses.pairs === 1, `${what} has other references`);
    check(mesh.uses.condensed === (i === 1 ? 2 : 0), `${what} has other streams`);
    check(!mesh.uses.unequal_copies, `copies of a point differ in ${what}`);
    let explained = 0;
    for (const [, at, cell] of examples[i].matchAll(/^\| ([0-9a-f]{2}) \| (`[^|]*) \|/gm)) {
      const bytes = from_hex(quoted(cell, '[0-9a-f ]').join(''));
      const place = parseInt(at, 16);
      check(bytes.equals(dump.subarray(place, place + bytes.length)), `${what} has other bytes at ${at}`);
      explained += bytes.length;
    }
    check(explained === wanted, `${explained} bytes of ${what} are explained`);
  });
  // The tables of bits: the directory and a part of the stitch map; the directory, the tables, and the last byte of a stream.
  const [first, second] = dumps;
  const parts = [[first.subarray(0x14, 0x1b), first.subarray(0x1b, 0x20)],
    [second.subarray(0x14, 0x1b), second.subarray(0x1d, 0x5d), second.subarray(0x66, 0x67)]];
  parts.forEach((wanted, i) => {
    const tables = examples[i].split(/^\| bits \|.*$/m).slice(1).map((table) => table.trimStart().split('\n\n')[0]);
    wanted.forEach((bytes, t) => {
      const said = [...tables[t].matchAll(/^\| (`[^|]*) \|/gm)].flatMap(([, cell]) =>
        quoted(cell, '[0-9a-f ]').map((text) => (/^[01]+$/.test(text) && text !== '00' ? text : to_bits(from_hex(text)))));
      check(said.join('') === to_bits(bytes), `table ${t + 1} of bits in example ${i + 1}`);
    });
  });
}

const scene = in_scratch('scene.glb');
run('generate', '-q', scene, '--shape', 'scene', '--faces', 60000, '--seed', 5, '--normals', '--texcoords');
const ways = [
  ['--patches', 40],
  ['--patches', 90, '--lossless', '--encode-speed', 0],
  ['--patches', 9, '--encode-speed', 10],
  ['--patches', 40, '--condense'],
  ['--patches', 600, '--condense', '--encode-speed', 0, '--profile', 'size'],
  ['--patches', 30, '--condense', '--lossless'],
  ['--patches', 20, '--condense', '--profile', 'size'],
];
ways.forEach((way, i) => {
  const encoded = in_scratch(`scene-${i}.glb`);
  run('encode', '-q', '--always-patches', ...way, scene, encoded);
  compare(encoded);
});
// Every feature of the format must occur, or else it is not tested.
for (const use of ['targets', 'residues', 'dropped_faces', 'runs', 'forward_runs', 'repeats', 'pairs', 'fallbacks',
  'condensed', 'stored', 'valence_contexts', 'history_contexts', 'other_skeletons', 'other_sets', 'border_values',
  'split_events', 'seams', 'raw_values', 'creases', 'orientations', 'flips', 'backward', 'means', 'values_by_0_parallelograms',
  'values_by_1_parallelograms', 'values_by_2_parallelograms'])
  check(uses[use] > 0, `no asset has ${use}`);

// Containers with one or two bytes changed, before the first stream if that is Draco's: both decoders must agree on them.
let random_state = 1;
const random = (below) => {
  random_state = (Math.imul(random_state, 1664525) + 1013904223) >>> 0;
  return Math.floor((random_state / 2 ** 32) * below);
};
const said = { valid: 0, invalid: 0 };
function both_say_the_same(bytes, what) {
  const file = in_scratch('mutant.glb');
  writeFileSync(file, bytes);
  let by_page = 'valid', why = '', mesh;
  try {
    const mutated = load(file);
    mesh = decode_primitive(draco, mutated, primitives_of(mutated)[0]);
  } catch (error) {
    if (!(error instanceof Invalid)) throw error;
    by_page = 'invalid';
    why = error.message;
  }
  const decoded = spawnSync(psplit, ['decode', '-q', file, in_scratch('plain.glb')], { encoding: 'utf8' });
  // The page lets decoders refuse copies that differ, as gltf-psplit does.
  if (mesh?.uses.unequal_copies && decoded.status === 3) return 'invalid';
  // Values may have changed: then the container is valid, but the accessor is not.
  const has_other_bounds = decoded.stderr.includes('[accessor-bounds]');
  const by_psplit = has_other_bounds ? 'valid'
    : { 0: 'valid', 3: 'invalid', 5: 'invalid' }[decoded.status] ?? `exit code ${decoded.status}`;
  check(by_page === by_psplit,
    `${what}: ${by_page} by the page (${why}), ${by_psplit} by gltf-psplit (${decoded.stderr.trim()})`);
  said[by_page] += 1;
  if (by_page !== 'valid' || by_psplit !== 'valid' || has_other_bounds) return by_page;
  const plain = load(in_scratch('plain.glb'));
  check(same(mesh.indices, accessor_indices(plain, primitives_of(plain)[0].indices)), `${what}: other indices`);
  return by_page;
}
function change_bytes(name, mutants) {
  const asset_bytes = new Uint8Array(readFileSync(path.join(samples, name)));
  const asset = load(path.join(samples, name));
  const view = asset.json.bufferViews[primitives_of(asset)[0].extensions.PSPLIT_mesh_draco_patches.bufferView];
  const container = asset.buffers[0].byteOffset + (view.byteOffset ?? 0);
  const first = Buffer.from(asset_bytes.buffer).indexOf('DRACO', container);
  const streams = first < 0 ? view.byteLength : first - container;
  check(streams > 100, `${name}: no stitch map to change`);
  for (let mutant = 0; mutant < mutants; ++mutant) {
    const bytes = asset_bytes.slice();
    for (let edit = mutant % 2; edit >= 0; --edit) {
      // Small changes are tried as well.
      const at = container + random(streams);
      bytes[at] = random(2) === 0 ? random(256) : bytes[at] + 1 - 2 * random(2);
    }
    both_say_the_same(bytes, `${name}, mutant ${mutant}`);
  }
}
change_bytes('residue.glb', 400);
change_bytes('condensed.glb', 200);
change_bytes('condensed-speed-0.glb', 100);
change_bytes('condensed-borders.glb', 300);
change_bytes('condensed-deltas.glb', 300);
// The residue's flag must agree with the last stream: set if that is sequential.
run('generate', '-q', in_scratch('small.glb'), '--faces', 300);
run('encode', '-q', '--patches', 1, '--always-patches', in_scratch('small.glb'), in_scratch('one.glb'));
for (const file of [path.join(samples, 'residue.glb'), in_scratch('one.glb')]) {
  const bytes = new Uint8Array(readFileSync(file));
  bytes[Buffer.from(bytes.buffer).indexOf('PSPL\x01') + 5] ^= 1;
  const what = `${path.basename(file)} with the other flag`;
  check(both_say_the_same(bytes, what) === 'invalid', `${what} is valid`);
}
check(said.valid > 10 && said.invalid > 100, 'too few valid or invalid mutants');

console.log(`seen: ${JSON.stringify(uses)}; changed containers: ${JSON.stringify(said)}`);
finish('page');
