// Meshes to encode: the arguments of the public functions, checked, and what an instance of psplit_encoder.wasm makes of them.
import { PsplitError } from './error.js';
import { Instance } from './instance.js';
import { kArrays, kTypes } from './types.js';

const invalid = (message) => new PsplitError(message, 'invalid-input');
const bytes_of = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
const is_object = (value) => value !== null && typeof value === 'object';

// glTF's numbers of the types that a mesh may have.
const kGltfTypes = { int8: 5120, uint8: 5121, int16: 5122, uint16: 5123, uint32: 5125, float32: 5126 };
const kMostPoints = 0xfffffffe, kMostComponents = 16;

// Each option has its default, and a function that checks a value and returns its number for the module.
const a_number = (least, most, is_integer = true) => (value) =>
  (typeof value === 'number' && value >= least && value <= most && (!is_integer || Number.isInteger(value)) ? value : undefined);
const bits = (least = 1) => a_number(least, 30);
const a_choice = (...names) => (value) => (names.includes(value) ? names.indexOf(value) : undefined);
const a_flag = (value) => (typeof value === 'boolean' ? Number(value) : undefined);
const is_point = (value) => Array.isArray(value) && value.length === 3 && value.every(Number.isFinite);
const kOptions = {
  patches: [0, a_number(0, 0xffffffff)],
  patchFaces: [0, a_number(0, 0xffffffff)],
  minFaces: [0, a_number(0, 0xffffffff)],
  profile: ['balanced', a_choice('balanced', 'speed', 'size')],
  positionBits: [14, (value) => (value === 'auto' ? 14 : bits()(value))],
  normalBits: [10, bits(2)],
  texcoordBits: [12, bits()],
  colorBits: [8, bits()],
  genericBits: [12, bits()],
  morphBits: [0, a_number(0, 30)],
  lossless: [false, a_flag],
  positionBitsBy: [0, a_number(0, 2)],  // not the caller's: see numbers_of
  maxError: [0, a_number(0, Number.MAX_VALUE, false)],
  encodeSpeed: [5, a_number(0, 10)],
  chooseByBytes: [false, a_flag],  // nor this
  keepDuplicates: [false, a_flag],
  keepDegenerate: [false, a_flag],
  keepUnused: [false, a_flag],
  condense: [false, a_flag],
  boxes: [false, a_flag],
  order: ['cut', (value) => (is_point(value?.near) ? 2 : a_choice('cut', 'size')(value))],
  nearX: [0, a_number(-Infinity, Infinity, false)],
  nearY: [0, a_number(-Infinity, Infinity, false)],
  nearZ: [0, a_number(-Infinity, Infinity, false)],
  verify: [true, a_flag],
  points: [false, a_flag],
};
const kNames = Object.keys(kOptions), kOwnNames = ['positionBitsBy', 'chooseByBytes', 'nearX', 'nearY', 'nearZ'];

// The options in the order of container_exports.cpp.
function numbers_of(given) {
  for (const name of kOwnNames) if (name in given) throw invalid(`there is no option \`${name}\``);
  const options = { ...given }, is_stated = (name) => given[name] != null && given[name] !== 0 && given[name] !== false;
  for (const [a, b] of [['patches', 'patchFaces'], ['maxError', 'positionBits'], ['lossless', 'positionBits'], ['lossless', 'maxError']])
    if (is_stated(a) && is_stated(b)) throw invalid(`the options \`${a}\` and \`${b}\` exclude each other`);
  options.positionBitsBy = is_stated('maxError') ? 2 : given.positionBits === 'auto' ? 1 : 0;
  options.chooseByBytes = given.profile === 'size' && given.encodeSpeed == null;
  if (is_point(given.order?.near)) [options.nearX, options.nearY, options.nearZ] = given.order.near;
  const numbers = kNames.map((name) => {
    const [by_default, check] = kOptions[name], number = check(options[name] ?? by_default);
    if (number === undefined) throw invalid(`the option \`${name}\` cannot be ${String(options[name])}`);
    return number;
  });
  // 2 chooses the smallest coding.
  if (options.condense && options.profile === 'size') numbers[kNames.indexOf('condense')] = 2;
  return Float64Array.from(numbers);
}

function attribute_of(name, given) {
  const components = given?.componentCount ?? given?.itemSize, { array, normalized = false } = given ?? {};
  const type = kTypes[kArrays.findIndex((Type) => Type !== undefined && array instanceof Type)];
  if (array instanceof Uint8ClampedArray) return attribute_of(name, { ...given, array: new Uint8Array(array.buffer, array.byteOffset, array.length) });
  if (kGltfTypes[type] === undefined) throw invalid(`${name} has no array of a type that glTF has`);
  if (!Number.isInteger(components) || components < 1 || components > kMostComponents)
    throw invalid(`${name}: no component count from 1 to ${kMostComponents}`);
  if (array.length % components !== 0) throw invalid(`${name}: the array has no whole number of points`);
  return { name, type, componentCount: components, normalized: normalized === true, array };
}

function mesh_of(given, is_cloud) {
  if (!is_object(given?.attributes)) throw invalid('the mesh has no attributes');
  const attributes = Object.entries(given.attributes).map(([name, attribute]) => attribute_of(name, attribute));
  const position = attributes.find(({ name }) => name === 'POSITION');
  if (position === undefined) throw invalid('the mesh has no POSITION');
  const points = position.array.length / position.componentCount;
  for (const { name, array, componentCount } of attributes)
    if (array.length !== points * componentCount)
      throw invalid(`${name} has ${array.length / componentCount} points, but POSITION has ${points}`);
  if (points > kMostPoints) throw new PsplitError(`${points} points are more than a container can hold`, 'unsupported');
  const { indices, distinct } = given;
  if (indices != null && ![Uint8Array, Uint16Array, Uint32Array].some((Type) => indices instanceof Type))
    throw invalid('the indices are neither a Uint8Array, a Uint16Array nor a Uint32Array');
  if (is_cloud && (indices != null || distinct != null)) throw invalid('a point cloud has neither indices nor bytes `distinct`');
  if (!is_cloud && (indices?.length ?? points) % 3 !== 0) throw invalid('the indices are not whole faces');
  if (distinct != null && (!ArrayBuffer.isView(distinct) || (points > 0 && distinct.byteLength % points !== 0)))
    throw invalid('the bytes `distinct` are not as many for each point');
  return { indices: is_cloud ? new Uint32Array(0) : indices ?? undefined, points, attributes, distinct: distinct == null ? undefined : bytes_of(distinct) };
}

/**
 * The job of a list of meshes. Beside what encode.d.ts says, two options are for psplit/gltf-transform: with `leave`, a mesh that cannot be
 * encoded has the result { unsupported: why }; `offsets` are vectors, three numbers each, by which nodes move meshes against each other.
 * Then results have `meets`: whether the grid is one on which surfaces that touch do so afterwards.
 * @returns {{ meshes: object[], numbers: Float64Array, exact: string[], grids: number[], decoded: boolean, leave: boolean, offsets?: Float64Array }}
 */
export function encode_job(meshes, options) {
  const { exact = [], decoded = false, leave = false, grids, offsets, signal, onProgress, transfer, ...rest } = options ?? {};
  for (const name of Object.keys(rest)) if (!kNames.includes(name)) throw invalid(`there is no option \`${name}\``);
  if (!Array.isArray(exact) || exact.some((name) => typeof name !== 'string')) throw invalid('the option `exact` is not an array of names');
  if (onProgress != null && typeof onProgress !== 'function') throw invalid('the option `onProgress` is not a function');
  if (!Array.isArray(meshes) || meshes.length === 0) throw invalid('there are no meshes');
  const is_cloud = rest.points === true;
  const job = { meshes: meshes.map((mesh) => mesh_of(mesh, is_cloud)), numbers: numbers_of(rest), is_cloud, exact, grids: grids ?? meshes.map(() => 0), decoded, leave, offsets };
  if (!Array.isArray(job.grids) || job.grids.length !== meshes.length || !job.grids.every((grid) => Number.isInteger(grid) && grid >= 0))
    throw invalid('the option `grids` is not a number for each mesh');
  return job;
}

// An instance of its own: the memory goes with it.
class Encoding {
  #instance;
  #exports;
  #handle;
  #meets;

  constructor(module, { meshes, numbers, exact, grids, offsets }, report) {
    this.#instance = new Instance(module, { psplit: { faces_encoded: report } }, 'encoder');
    this.#exports = this.#instance.exports;
    this.#handle = this.#exports.new_encoding();
    meshes.forEach((mesh, i) => this.#add(mesh, grids[i]));
    for (const name of exact) this.#with_text(name, (at, bytes) => this.#exports.keep_exactly(this.#handle, at, bytes));
    const at = this.#instance.copy_in(numbers), failed = this.#exports.choose_codings(this.#handle, at);
    if (failed >= 0) throw in_mesh(this.#instance.last_error(), failed, meshes.length);
    this.#exports.release(at);
    if (offsets === undefined) return;
    const from = this.#instance.copy_in(offsets);
    this.#meets = this.#exports.fit_offsets(this.#handle, from, offsets.length / 3) !== 0;
    this.#exports.release(from);
  }

  encode(i, { attributes }, { decoded: with_decoded, is_cloud, leave, meshes }) {
    const at = this.#exports.encode(this.#handle, i);
    if (at === 0) {
      const error = this.#instance.last_error();
      if (leave && error.code === 'unsupported') return { unsupported: error.message };
      throw in_mesh(error, i, meshes.length);
    }
    const words = this.#view(Uint32Array, at, 12 + 3 * attributes.length);
    const [container, byte_count, pointCount, faceCount, patchCount, streams, mergedPoints, droppedPoints, droppedFaces, headBytes,
      source_points, faces] = words;
    const copy = (Type, from, length) => this.#view(Type, from, length).slice();
    const error = this.#exports.position_error(this.#handle);
    const bytes = copy(Uint8Array, container, byte_count);
    return { ...(is_cloud ? { stream: bytes, pointCount } : { container: bytes, faceCount, pointCount, patchCount, hasResidue: streams > patchCount }),
      attributes: attributes.map(({ name, type, componentCount, normalized }, k) => {
        const [uniqueId, bits, values] = words.subarray(12 + 3 * k);
        return { name, uniqueId, type, componentCount, normalized, bits,
          ...(with_decoded && { array: copy(kArrays[kTypes.indexOf(type)], values, pointCount * componentCount) }) };
      }),
      ...(with_decoded && !is_cloud && { indices: copy(Uint32Array, faces, 3 * faceCount) }),
      sourcePoints: copy(Uint32Array, source_points, pointCount),
      ...(!is_cloud && { mergedPoints, droppedPoints, droppedFaces, headBytes, meets: this.#meets }), ...(!Number.isNaN(error) && { positionError: error }) };
  }

  #view(Type, at, length) {
    return this.#instance.view(Type, at, length);
  }
  #add({ indices, points, attributes, distinct }, grid) {
    const face_count = (indices?.length ?? points) / 3;
    const faces = this.#view(Uint32Array, this.#exports.add_mesh(this.#handle, points, face_count, grid), 3 * face_count);
    if (indices !== undefined) faces.set(indices);
    else for (let i = 0; i < points; ++i) faces[i] = i;
    for (const { name, type, componentCount, normalized, array } of attributes) {
      const at = this.#with_text(name, (text, bytes) =>
        this.#exports.add_attribute(this.#handle, text, bytes, kGltfTypes[type], componentCount, normalized));
      this.#view(Uint8Array, at, array.byteLength).set(bytes_of(array));
    }
    if (distinct === undefined || points === 0) return;
    const at = this.#exports.add_distinct(this.#handle, distinct.length / points);
    this.#view(Uint8Array, at, distinct.length).set(distinct);
  }
  #with_text(text, use) {
    const bytes = new TextEncoder().encode(text), at = this.#instance.copy_in(bytes);
    const result = use(at, bytes.length);
    this.#exports.release(at);
    return result;
  }
}
const in_mesh = (error, i, count) => (count === 1 ? error : Object.assign(error, { message: `mesh ${i}: ${error.message}` }));

/**
 * Encodes meshes, one after the other. `report(done, total)` is told the faces that are encoded.
 * @param {WebAssembly.Module} module
 * @returns {object[]} what encodeMesh of encode.d.ts resolves to, for each mesh
 */
export function encode_meshes(module, job, report) {
  const counts = job.meshes.map(({ indices, points }) => (indices?.length ?? points) / 3), total = counts.reduce((a, b) => a + b, 0);
  let done = 0, before = 0;
  const advance = (to) => to > done && report?.((done = to), total);
  return Instance.guarded_as('encoder', () => {
    const encoding = new Encoding(module, job, (faces) => advance(before + faces));
    return job.meshes.map((mesh, i) => {
      const result = encoding.encode(i, mesh, job);
      advance(before += counts[i]);  // also with faces that are dropped
      return result;
    });
  });
}

/** The buffers of results, for a transfer between threads. */
export const buffers_of = (results) => results.flatMap(({ container, stream, sourcePoints, indices, attributes = [] }) =>
  [container, stream, sourcePoints, indices, ...attributes.map(({ array }) => array)].filter((array) => array !== undefined).map(({ buffer }) => buffer));
