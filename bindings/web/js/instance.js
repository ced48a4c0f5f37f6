// One instance of the WebAssembly module: calls its exports, and copies bytes in and arrays out. Synchronous.
import { Container, kOutline } from './container.js';
import { decode_alone, decode_arriving, decode_as_helper, decode_as_lead } from './container_job.js';
import { PsplitError } from './error.js';
import { kArrays, kSemantics, kTypes } from './types.js';

const kStatusUsage = 1, kStatusInvalid = 3, kStatusUnsupported = 5;

// An instance that holds more memory than this is dropped when it had no work for a while. Memory of WebAssembly never
// shrinks, and new memory costs time at its first use.
const kMostKeptBytes = 64 * 1024 * 1024, kKeptMs = 2000;

export class Instance {
  #exports;
  #what;
  #broken = false;

  /** @param {WebAssembly.Module} module @param {object} [imports] @param {string} [what] for messages */
  constructor(module, imports = {}, what = 'decoder') {
    this.#exports = new WebAssembly.Instance(module, imports).exports;
    this.#what = what;
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
      // Meshes of few faces are decoded in the time of some of JavaScript's conveniences: here and below, words have numbers.
      const counts = this.#words(this.#exports.stream_counts(stream), 3), faceCount = counts[0], pointCount = counts[1], stored = [];
      for (let i = 0, attribute_count = counts[2]; i < attribute_count; ++i) stored.push(this.#stream_attribute(stream, i));
      const indices = this.#words(this.#exports.stream_faces(stream), 3 * faceCount).slice(), attributes = [];
      for (const request of requests ?? stored) {
        const is_wanted = (of) => (request.semantic === undefined ? of.uniqueId === request.uniqueId : of.name === request.semantic);
        const i = stored.findIndex(is_wanted);
        if (i < 0 && request.semantic !== undefined) continue;
        if (i < 0) throw new PsplitError(`no attribute has the unique id ${request.uniqueId}`, 'invalid-input');
        attributes.push(this.#stream_values(stream, i, request, stored[i], pointCount));
      }
      return { faceCount, pointCount, indices, attributes };
    });
  }

  // container_job.js describes `options` and `post`.
  decode_container(bytes, attributes, options, post) {
    return this.guarded(() => decode_alone(this, { ...options, bytes, attributes }, post));
  }

  #stream_attribute(stream, i) {
    const words = this.#words(this.#exports.stream_attribute(stream, i), 5);
    return { name: kSemantics[words[0]], uniqueId: words[4], type: kTypes[words[1]], componentCount: words[2], normalized: words[3] !== 0 };
  }
  #stream_values(stream, i, request, { uniqueId, type: stored_type, componentCount, normalized }, point_count) {
    const { name } = request, type = request.type ?? stored_type, number = kTypes.indexOf(type);
    if (number < 1) throw new PsplitError(`${name}: unknown type ${type}`, 'invalid-input');
    const array = this.#written(kArrays[number], point_count * componentCount, (out) => {
      if (!this.#exports.write_attribute(stream, i, number, out))
        throw new PsplitError(`${name}: a value does not fit ${type}`, 'invalid-input');
    });
    return { name, uniqueId, type, componentCount, normalized, array };
  }

  get exports() {
    return this.#exports;
  }
  // Calls use(handle) with what `open` makes of the bytes.
  #with_handle(bytes, open, free, use) {
    return this.guarded(() => {
      const handle = this.open(open, bytes);
      try {
        return use(handle);
      } finally {
        if (!this.#broken) this.#exports[free](handle);
      }
    });
  }
  // Calls use(). A trap of the module breaks the instance.
  guarded(use) {
    return Instance.guarded_as(this.#what, use, () => (this.#broken = true));
  }
  static guarded_as(what, use, on_failure = () => {}) {
    try {
      return use();
    } catch (error) {
      if (error instanceof PsplitError) throw error;
      on_failure();
      const is_memory = error instanceof WebAssembly.RuntimeError || error instanceof RangeError;
      throw is_memory ? new PsplitError(`the ${what} has not enough memory (${error.message})`, 'out-of-memory')
        : new PsplitError(`the ${what} failed: ${error.message}`, 'failed');
    }
  }

  // The handle of what an export makes of the bytes.
  open(name, bytes, ...options) {
    const handle = this.#exports[name](this.copy_in(bytes), bytes.length, ...options);
    if (handle === 0) throw this.last_error();
    return handle;
  }
  // The address of memory with the bytes of a typed array.
  copy_in({ buffer, byteOffset, byteLength }) {
    const at = this.#allocate(byteLength);
    // A buffer that was transferred since the call has no bytes.
    if (byteLength > 0) this.view(Uint8Array, at, byteLength).set(new Uint8Array(buffer, byteOffset, byteLength));
    return at;
  }
  // A view of memory, which is valid until the next call.
  view(Type, at, length) {
    return new Type(this.#exports.memory.buffer, at >>> 0, length);
  }
  #allocate(bytes) {
    const at = this.#exports.allocate(bytes) >>> 0;
    if (at === 0) throw new PsplitError(`the ${this.#what} has not enough memory`, 'out-of-memory');
    return at;
  }
  // A new array of what write(address) writes.
  #written(Type, length, write) {
    const at = this.#allocate(length * Type.BYTES_PER_ELEMENT);
    try {
      write(at);
      return this.view(Type, at, length).slice();
    } finally {
      this.#exports.release(at);
    }
  }
  #words(at, count) {
    return this.view(Uint32Array, at, count);
  }
  last_error() {
    const [code, patch, at, length] = this.#words(this.#exports.last_error(), 4);
    const message = new TextDecoder().decode(new Uint8Array(this.#exports.memory.buffer, at, length));
    return new PsplitError(message,
      code === kStatusInvalid || code === kStatusUsage ? 'invalid-input' : code === kStatusUnsupported ? 'unsupported' : 'failed',
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
  get module() {
    return this.#module;
  }

  // Runs a job: { kind: 'draco' | 'container', bytes, attributes }, and for containers what container_job.js says.
  run(job, post) {
    const instance = this.#take();
    try {
      return job.kind === 'draco' ? instance.decode_draco(job.bytes, job.attributes)
        : instance.decode_container(job.bytes, job.attributes, job, post);
    } finally {
      this.#give_back();
    }
  }
  // Takes part in a job of several workers, or decodes a container that arrives: inbox.next() resolves to its next chunk, or
  // null. Resolves to the result, unless this one is a helper.
  async run_part(job, post, inbox) {
    const instance = this.#take(), decode = job.arrives ? decode_arriving : job.part === 0 ? decode_as_lead : decode_as_helper;
    try {
      return await decode(instance, job, post, inbox);
    } finally {
      this.#give_back();
    }
  }

  // Calls use(container) with the outline of a container.
  with_outline(front, use) {
    const instance = this.#take();
    try {
      return instance.guarded(() => {
        const container = new Container(instance, front, kOutline);
        try {
          return use(container);
        } finally {
          container.free();
        }
      });
    } finally {
      this.#give_back();
    }
  }

  #take() {
    clearTimeout(this.#timer);
    return (this.#instance ??= new Instance(this.#module));
  }
  #give_back() {
    if (this.#instance.broken) this.#instance = null;
    else if (this.#instance.memory_bytes > kMostKeptBytes) this.#drop_later();
  }
  #drop_later() {
    this.#timer = setTimeout(() => (this.#instance = null), kKeptMs);
    this.#timer.unref?.();
  }
}

const decoders = new WeakMap();  // by module
/** The decoder of this thread for a module. */
export function decoder_of(module) {
  if (!decoders.has(module)) decoders.set(module, new Decoder(module));
  return decoders.get(module);
}

// The buffers of a result, for a transfer between threads. Shared ones need none.
export const buffers_of = ({ indices, attributes }) =>
  [indices, ...attributes.map(({ array }) => array)].map(({ buffer }) => buffer).filter((buffer) => buffer instanceof ArrayBuffer);
