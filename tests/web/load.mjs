// What the tests read: the built package, stock Draco, and files.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

export const root = fileURLToPath(new URL('../../', import.meta.url));
export const package_folder = path.join(root, 'build/web/psplit');
export const modules_folder = path.join(root, 'build/web/modules');
export const checked_module = path.join(root, 'build/web/checked.wasm');
function link(target, name) {
  try {
    symlinkSync(target, name);
  } catch (error) {
    if (error.code !== 'EEXIST') throw error;
  }
}
// The package finds its optional peers there, as in a project that installs both.
link('modules/node_modules', path.join(root, 'build/web/node_modules'));
// Makes the package one of the modules, as in a project that installs it.
export const link_package = () => link('../../psplit', path.join(modules_folder, 'node_modules/psplit'));
export const psplit = await import(pathToFileURL(path.join(package_folder, 'index.js')));
export const stock = createRequire(path.join(modules_folder, 'package.json'))('draco3d');

// The sample of several files.
export const samples_folder = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
export const fallback_files = ['fallback.gltf', ...JSON.parse(readFileSync(path.join(samples_folder, 'fallback.gltf'))).buffers.map(({ uri }) => uri)];

const corpus = process.env.PSPLIT_CORPUS ?? path.join(root, '../shared/corpus');
export const corpus_folder = existsSync(corpus) ? corpus : null;

// The native tool, which encodes what tests decode.
export const gltf_psplit = [process.env.PSPLIT, ...['release', 'bench'].map((build) => path.join(root, 'build', build, 'gltf-psplit'))]
  .find((file) => file !== undefined && existsSync(file)) ?? null;

// The code of web/README.md: by heading, the blocks in JavaScript, TypeScript or HTML.
export function readme_blocks() {
  const sections = readFileSync(path.join(root, 'bindings/web/README.md'), 'utf8').split(/^## /m).slice(1);
  return Object.fromEntries(sections.map((section) =>
    [section.slice(0, section.indexOf('\n')), [...section.matchAll(/^```(?:html|js|tsx?)\n(.*?)^```$/gms)].map(([, code]) => code)]));
}

export function files_below(folder, pattern) {
  return readdirSync(folder, { recursive: true }).filter((name) => pattern.test(name)).sort()
    .map((name) => path.join(folder, name));
}

// The parts of a glTF file.
export function read_asset(file) {
  const bytes = new Uint8Array(readFileSync(file));
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const is_glb = bytes.length > 20 && view.getUint32(0, true) === 0x46546c67;
  const json_bytes = is_glb ? view.getUint32(12, true) : bytes.length;
  const json = JSON.parse(new TextDecoder().decode(is_glb ? bytes.subarray(20, 20 + json_bytes) : bytes));
  const buffer_bytes = ({ uri }) => {
    if (uri === undefined) return bytes.subarray(28 + json_bytes);
    if (uri.startsWith('data:')) return new Uint8Array(Buffer.from(uri.slice(uri.indexOf(',') + 1), 'base64'));
    return new Uint8Array(readFileSync(path.join(path.dirname(file), decodeURIComponent(uri))));
  };
  const view_bytes = (i) => {
    const { buffer, byteOffset = 0, byteLength } = json.bufferViews[i];
    return buffer_bytes(json.buffers[buffer]).subarray(byteOffset, byteOffset + byteLength);
  };
  return { json, view_bytes };
}

const kTypes = { 5120: 'int8', 5121: 'uint8', 5122: 'int16', 5123: 'uint16', 5125: 'uint32', 5126: 'float32' };
const kComponents = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };

// The primitives of a mesh, also if its own are coarse ones.
export const fine_primitives = (mesh) => mesh.extensions?.PSPLIT_mesh_draco_patches?.primitives ?? mesh.primitives;

// The primitives of an asset that an extension compresses: their bytes, and the attributes that they declare.
export function compressed_primitives(file, extension) {
  const { json, view_bytes } = read_asset(file);
  return (json.meshes ?? []).flatMap(fine_primitives).flatMap((primitive) => {
    const compressed = primitive.extensions?.[extension];
    if (compressed === undefined) return [];
    const request = (name, uniqueId, accessor) => {
      const { componentType, type, normalized = false } = json.accessors[accessor];
      return { name, uniqueId, type: kTypes[componentType], componentCount: kComponents[type], normalized };
    };
    const attributes = Object.entries(compressed.attributes).map(([name, uniqueId]) => request(name, uniqueId, primitive.attributes[name]));
    const targets = Object.entries(compressed.targets ?? {}).flatMap(([name, ids]) => ids.flatMap((uniqueId, t) =>
      (uniqueId < 0 ? [] : [request(`targets/${t}/${name}`, uniqueId, primitive.targets[t][name])])));
    return [{ bytes: view_bytes(compressed.bufferView), attributes: [...attributes, ...targets] }];
  });
}

// The Draco streams of the corpus, as [file, bytes].
export function* corpus_streams() {
  for (const file of files_below(corpus_folder, /\.drc$/)) yield [file, new Uint8Array(readFileSync(file))];
  for (const file of files_below(path.join(corpus_folder, 'gltf'), /\.(glb|gltf)$/))
    for (const { bytes } of compressed_primitives(file, 'KHR_draco_mesh_compression')) yield [file, bytes];
}

// A mesh in patches: use(file) gets the GLB. `source` has the number of faces of a new mesh with normals and texture coordinates, or the
// bytes of a GLB.
export function with_asset(source, options, use) {
  const folder = mkdtempSync(path.join(tmpdir(), 'psplit-container-')), file = (name) => path.join(folder, name);
  const run = (...arguments_) => execFileSync(gltf_psplit, [...arguments_, '-q']);
  try {
    if (typeof source === 'number') run('generate', file('mesh.glb'), '--shape', 'terrain', '--faces', String(source), '--seed', '1', '--normals', '--texcoords');
    else writeFileSync(file('mesh.glb'), source);
    run('encode', file('mesh.glb'), file('patches.glb'), ...options);
    return use(file('patches.glb'));
  } finally {
    rmSync(folder, { recursive: true });
  }
}
// The container of one, and its attributes.
export const make_container = (source, patch_faces, ...options) =>
  with_asset(source, ['--patch-faces', String(patch_faces), ...options], (file) => compressed_primitives(file, 'PSPLIT_mesh_draco_patches')[0]);

// Equal numbers for equal seeds.
export function random_numbers(seed) {
  let state = seed >>> 0;
  return (below) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}
