// One instance of the WebAssembly module: calls its exports, and copies bytes in and arrays out. Synchronous.
import { PsplitError } from './error.js';

// By Draco's number of a type.
const kArrays = [undefined, Int8Array, Uint8Array, Int16Array, Uint16Array, Int32Array, Uint32Array, BigInt64Array,
  BigUint64Array, Float32Array, Float64Array, Uint8Array];
const kTypes = [undefined, 'int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'int64', 'uint64', 'float32', 'float64',
  'bool'];
const kSemantics = ['POSITION', 'NORMAL', 'COLOR', 'TEX_COORD', 'GENERIC'];
// glTF's number of a type.
const kComponentTypes = { int8: 5120, uint8: 5121, int16: 5122, uint16: 5123, uint32: 5125, float32: 5126 };
const kStatusInvalid = 3, kStatusUnsupported = 5;

// An instance that holds more memory than this is dropped when it had no work for a while. Memory of WebAssembly never
// shrinks, and new memory costs time at its first use.
const kMostKeptBytes = 64 * 1024 * 1024, kKeptMs = 2000;

export class Instance {
  #exports;
  #broken = false;

  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.#exports = new WebAssembly.Instance(module, {}).exports;
  }

  // A broken instance must not be used any more.
  get broken() {
    return this.#broken;
  }
  get memory_bytes() {
    return this.#exports.memory.buffer.byteLength;
  }

  decode_draco(bytes, requests) {
    return this.#with_handle(bytes, 'decode_stream', 'free_stream', (stream) => {
      const [face_count, point_count, attribute_count] = this.#words(this.#exports.stream_counts(stream), 3);
      const stored = Array.from({ length: attribute_count }, (_, i) => this.#stream_attribute(stream, i));
      const indices = this.#written(Uint32Array, 3 * face_count,
        (out) => this.#exports.write_faces(stream, 4, out));
      const attributes = (requests ?? stored).flatMap((request) => {
        const i = stored.findIndex(({ name, uniqueId }) =>
          (request.semantic === undefined ? uniqueId === request.uniqueId : name === request.semantic));
        if (i < 0 && request.semantic !== undefined) return [];
        if (i < 0) throw new PsplitError(`no attribute has the unique id ${request.uniqueId}`, 'invalid-input');
        return this.#stream_values(stream, i, { ...stored[i], ...request, uniqueId: stored[i].uniqueId }, point_count);
      });
      return { faceCount: face_count, pointCount: point_count, indices, attributes };
    });
  }

  #stream_attribute(stream, i) {
    const [semantic, type, component_count, normalized, unique_id] =
      this.#words(this.#exports.stream_attribute(stream, i), 9);
    return { name: kSemantics[semantic], uniqueId: unique_id, type: kTypes[type], componentCount: component_count,
      normalized: normalized !== 0 };
  }
  #stream_values(stream, i, { name, uniqueId, type, componentCount, normalized }, point_count) {
    const number = kTypes.indexOf(type);
    if (number < 1) throw new PsplitError(`${name}: unknown type ${type}`, 'invalid-input');
    const array = this.#written(kArrays[number], point_count * componentCount, (out) => {
      if (!this.#exports.write_attribute(stream, i, number, out))
        throw new PsplitError(`${name}: a value does not fit ${type}`, 'invalid-input');
    });
    return { name, uniqueId, type, componentCount, normalized, array };
  }

  decode_container(bytes, requests) {
    return this.#with_handle(bytes, 'open_container', 'free_container', (container) => {
      const [version, patch_count, has_residue, face_count, point_count] =
        this.#words(this.#exports.container_counts(container), 6);
      for (const request of requests) this.#request(container, request);
      if (!this.#exports.decode_container(container)) throw this.#last_error();
      const copy = (Type, at, length) => new Type(this.#exports.memory.buffer, at, length).slice();
      return {
        faceCount: face_count, pointCount: point_count, version, patchCount: patch_count,
        hasResidue: has_residue !== 0,
        indices: copy(Uint32Array, this.#exports.container_faces(container), 3 * face_count),
        attributes: requests.map(({ name, uniqueId, type, componentCount, normalized = false }, i) => ({
          name, uniqueId, type, componentCount, normalized,
          array: copy(kArrays[kTypes.indexOf(type)], this.#exports.container_values(container, i),
            point_count * componentCount),
        })),
      };
    });
  }

  #request(container, { name, uniqueId, type, componentCount, normalized = false }) {
    const component_type = kComponentTypes[type];
    if (component_type === undefined) throw new PsplitError(`${name}: ${type} is not a type of glTF`, 'invalid-input');
    const text = new TextEncoder().encode(name), at = this.#copy_in(text);
    this.#exports.request_attribute(container, at, text.length, uniqueId, component_type, componentCount,
      normalized ? 1 : 0);
    this.#exports.release(at);
  }

  // Calls use(handle) with what `open` makes of the bytes. A trap of the module breaks the instance.
  #with_handle(bytes, open, free, use) {
    try {
      const at = this.#copy_in(bytes);
      const handle = this.#exports[open](at, bytes.length);
      if (handle === 0) throw this.#last_error();
      try {
        return use(handle);
      } finally {
        if (!this.#broken) this.#exports[free](handle);
      }
    } catch (error) {
      if (error instanceof PsplitError) throw error;
      this.#broken = true;
      throw new PsplitError(`the decoder has not enough memory (${error.message})`, 'out-of-memory');
    }
  }

  #copy_in(bytes) {
    const at = this.#allocate(bytes.length);
    new Uint8Array(this.#exports.memory.buffer, at, bytes.length).set(bytes);
    return at;
  }
  #allocate(bytes) {
    const at = this.#exports.allocate(bytes) >>> 0;
    if (at === 0) throw new PsplitError('the decoder has not enough memory', 'out-of-memory');
    return at;
  }
  // A new array of what write(address) writes.
  #written(Type, length, write) {
    const at = this.#allocate(length * Type.BYTES_PER_ELEMENT);
    try {
      write(at);
      return new Type(this.#exports.memory.buffer, at, length).slice();
    } finally {
      this.#exports.release(at);
    }
  }
  #words(at, count) {
    return new Uint32Array(this.#exports.memory.buffer, at, count);
  }
  #last_error() {
    const [code, patch, at, length] = this.#words(this.#exports.last_error(), 4);
    const message = new TextDecoder().decode(new Uint8Array(this.#exports.memory.buffer, at, length));
    return new PsplitError(message,
      code === kStatusInvalid ? 'invalid-input' : code === kStatusUnsupported ? 'unsupported' : 'failed',
      patch === 0xffffffff ? undefined : patch);
  }
}

// An instance that is made when it is needed, and dropped when it broke, or is large and not needed.
export class Decoder {
  #module;
  #instance = null;
  #timer;

  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.#module = module;
  }

  // Runs a job: { kind: 'draco' | 'container', bytes, attributes }.
  run({ kind, bytes, attributes }) {
    clearTimeout(this.#timer);
    this.#instance ??= new Instance(this.#module);
    try {
      return kind === 'draco' ? this.#instance.decode_draco(bytes, attributes)
        : this.#instance.decode_container(bytes, attributes);
    } finally {
      if (this.#instance.broken) this.#instance = null;
      else if (this.#instance.memory_bytes > kMostKeptBytes) this.#drop_later();
    }
  }

  #drop_later() {
    this.#timer = setTimeout(() => (this.#instance = null), kKeptMs);
    this.#timer.unref?.();
  }
}

// The buffers of a result, for a transfer between threads.
export const buffers_of = ({ indices, attributes }) =>
  [indices.buffer, ...attributes.map((attribute) => attribute.array.buffer)];
