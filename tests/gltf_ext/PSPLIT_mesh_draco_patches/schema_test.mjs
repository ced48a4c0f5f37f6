// Tests the extension's JSON schema with a validator of JSON Schema 2020-12:
//
//   node schema_test.mjs GLTF_PSPLIT MODULES SPECIFICATION
//
// The samples, the output of encode and the specification's own example conform. Broken extension objects are refused, by
// the schema and by `gltf-psplit validate`. MODULES is the folder where npm installed tests/validator, SPECIFICATION the
// folder of the extension.
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { check, finish } from '../../support/checks.mjs';

const [psplit, modules, specification] = process.argv.slice(2).map((argument) => path.resolve(argument));
const Ajv = createRequire(path.join(modules, 'package.json'))('ajv/dist/2020').default;
const scratch = mkdtempSync(path.join(tmpdir(), 'psplit-schema-'));
process.on('exit', () => rmSync(scratch, { recursive: true, force: true }));
const kName = 'PSPLIT_mesh_draco_patches';

// The part of glTF's schema of every property that matters here.
const gltf_property = {
  $schema: 'https://json-schema.org/draft/2020-12/schema',
  $id: 'glTFProperty.schema.json',
  type: 'object',
  properties: { extensions: { type: 'object', additionalProperties: { type: 'object' } }, extras: {} },
};
const schema = JSON.parse(
  readFileSync(path.join(specification, `schema/mesh.primitive.${kName}.schema.json`), 'utf8'));
const gltf_primitive = {
  $schema: gltf_property.$schema,
  $id: 'mesh.primitive.schema.json',
  type: 'object',
  properties: { attributes: { type: 'object', minProperties: 1 }, indices: { type: 'integer', minimum: 0 } },
  required: ['attributes'],
};
const ajv = new Ajv({ allErrors: true });
ajv.addSchema(gltf_property);
ajv.addSchema(gltf_primitive);
const mesh_schema = JSON.parse(readFileSync(path.join(specification, `schema/mesh.${kName}.schema.json`), 'utf8'));
const mesh_conforms = ajv.compile(mesh_schema);
const conforms = ajv.compile(schema); // throws if it is not a schema of 2020-12
check(schema.$schema === gltf_property.$schema && schema.$id === `mesh.primitive.${kName}.schema.json`, 'names');
check(schema.title && Object.entries(schema.properties).every(([name, property]) =>
  name.startsWith('ext') || property.description), 'every property has a description');

function json_of(file) {
  const bytes = readFileSync(file);
  if (bytes.toString('latin1', 0, 4) !== 'glTF') return JSON.parse(bytes.toString());
  return JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
}
const fine_primitives = (mesh) => mesh.extensions?.[kName]?.primitives ?? mesh.primitives;
const extensions_of = (json) =>
  json.meshes.flatMap(fine_primitives).map((primitive) => primitive.extensions?.[kName])
    .filter((extension) => extension !== undefined);
function check_asset(json, what) {
  const extensions = extensions_of(json);
  check(extensions.length > 0, `${what}: no extension`);
  for (const extension of extensions)
    check(conforms(extension), `${what}: ${ajv.errorsText(conforms.errors)}`);
  for (const { extensions, primitives } of json.meshes) {
    if (extensions?.[kName] === undefined) continue;
    check(mesh_conforms(extensions[kName]), `${what}: ${ajv.errorsText(mesh_conforms.errors)}`);
    check(primitives.every((primitive) => primitive.extensions?.[kName] === undefined), `${what}: coarse primitives in patches`);
    check(!json.extensionsRequired?.includes(kName), `${what}: the extension is required`);
  }
}

const samples = readdirSync(path.join(specification, 'samples')).filter((name) => /\.(glb|gltf)$/.test(name));
check(samples.length >= 4, 'samples');
for (const name of samples) check_asset(json_of(path.join(specification, 'samples', name)), name);

const page = readFileSync(path.join(specification, 'README.md'), 'utf8');
const examples = [...page.matchAll(/^```json\n(.*?)^```/gms)].map(([, text]) => JSON.parse(text));
check(examples.length > 0, 'examples on the page');
for (const example of examples) check_asset(example, 'the example of the page');

const run = (...words) => execFileSync(psplit, words.map(String), { stdio: ['ignore', 'ignore', 'inherit'] });
const plain = path.join(scratch, 'scene.glb'), encoded = path.join(scratch, 'scene.gltf');
run('generate', '-q', plain, '--shape', 'scene', '--faces', 4000, '--normals', '--texcoords');
for (const fallback of ['uncompressed', 'coarse=20%', 'none']) {
  run('encode', '-q', '--always-patches', '--patches', 12, '--fallback', fallback, plain, encoded);
  check_asset(json_of(encoded), `encode with fallback ${fallback}`);
}

// Changes to a valid extension object, and whether [the schema, gltf-psplit] must refuse the result.
const both = [true, true], neither = [false, false];
const changes = [
  ['extras', (e) => ({ ...e, extras: { anything: [1] } }), neither],
  ['an unknown extension', (e) => ({ ...e, extensions: { EXT_unknown: {} } }), neither],
  ['an unknown member', (e) => ({ ...e, later: 1 }), neither],
  ['an integer written as a float',
    (e) => JSON.stringify(e).replace(/"bufferView":(\d+)/, '"bufferView":$1.0'), neither],
  ['not an object: array', (e) => [e], both],
  ['not an object: null', () => null, both],
  ['not an object: number', () => 0, both],
  ['extensions that are not an object', (e) => ({ ...e, extensions: 5 }), [true, false]],
  ['no bufferView', ({ attributes }) => ({ attributes }), both],
  ['bufferView: string', (e) => ({ ...e, bufferView: String(e.bufferView) }), both],
  ['bufferView: null', (e) => ({ ...e, bufferView: null }), both],
  ['bufferView: array', (e) => ({ ...e, bufferView: [e.bufferView] }), both],
  ['bufferView: -1', (e) => ({ ...e, bufferView: -1 }), both],
  ['bufferView: 0.5', (e) => ({ ...e, bufferView: 0.5 }), both],
  ['bufferView: out of range', (e) => ({ ...e, bufferView: 1000 }), [false, true]],
  ['no attributes', ({ bufferView }) => ({ bufferView }), both],
  ['attributes: empty', (e) => ({ ...e, attributes: {} }), both],
  ['attributes: array', (e) => ({ ...e, attributes: [0, 1] }), both],
  ['attributes: number', (e) => ({ ...e, attributes: 0 }), both],
  ...[-1, 0.5, '0', null, [0], true, 4294967296].map((id) =>
    [`id: ${JSON.stringify(id)}`, (e) => ({ ...e, attributes: { ...e.attributes, POSITION: id } }), both]),
  ['an attribute that the primitive lacks',
    (e) => ({ ...e, attributes: { ...e.attributes, _NO: 0 } }), [false, true]],
  ['an id that the streams lack',
    (e) => ({ ...e, attributes: { ...e.attributes, POSITION: 9 } }), [false, true]],
];
const sound = json_of(encoded);
const broken = path.join(scratch, 'broken.gltf');
for (const [what, change, [by_schema, by_psplit]] of changes) {
  const json = structuredClone(sound);
  const primitive = json.meshes[0].primitives[0];
  const changed = change(primitive.extensions[kName]);
  const text = typeof changed === 'string' ? changed : JSON.stringify(changed);
  check(conforms(JSON.parse(text)) === !by_schema, `${what}: the schema ${by_schema ? 'accepts' : 'refuses'} it`);
  primitive.extensions[kName] = 'HERE';
  writeFileSync(broken, JSON.stringify(json).replace('"HERE"', () => text));
  const { status, stderr } = spawnSync(psplit, ['validate', '-q', broken], { encoding: 'utf8' });
  check(status === (by_psplit ? 3 : 0), `${what}: gltf-psplit validate exits with ${status}: ${stderr.trim()}`);
}

finish('schema');
