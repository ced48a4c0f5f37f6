// psplit/encode: encodes meshes as containers of patches. `gltf-psplit encode` writes the same bytes.
import { compile_file, once } from './compile.js';
import { encode_job, encode_meshes } from './encode_job.js';
import { job_runner, node_worker, page_worker, wasm_file } from './encode_files.js';
import { PsplitError } from './error.js';
import { check_signal } from './job.js';
import { Workers } from './workers.js';

export { PsplitError } from './error.js';

const configured = { wasm: undefined, worker: undefined };
const compile = (wasm) => compile_file(wasm ?? configured.wasm, { name: 'psplit_encoder.wasm', file: wasm_file, has: 'choose_codings' });
let shared_module = once(() => compile());  // the default module

export function configure(options) {
  const { wasm, worker } = options ?? {};
  Object.assign(configured, { wasm, worker });
  shared_module = once(() => compile());
}

export async function encodeMeshes(meshes, options) {
  const { signal, onProgress } = options ?? {}, job = encode_job(meshes, options);
  check_signal(signal);
  const module = await shared_module();
  if (signal?.aborted) throw new PsplitError('aborted', 'aborted');
  // This thread is busy until all is done, but the caller's function may abort.
  return encode_meshes(module, job, (done, total) => {
    onProgress?.(done, total);
    if (signal?.aborted) throw new PsplitError('aborted', 'aborted');
  });
}
export async function encodeMesh(mesh, options) {
  return (await encodeMeshes([mesh], options))[0];
}

export async function encodePoints(points, options) {
  return encodeMesh(points, { ...options, points: true });
}

const kEncoders = { job_runner, node_worker, page_worker, does: 'encodes', worker: () => configured.worker };

// A job of an encoder: see Task of task.js. One worker does it.
class EncodeTask {
  members = [];
  most = 1;
  module;
  source = undefined;
  #job;
  #transfer;
  #on_progress;

  constructor(id, job, { onProgress, transfer = false }) {
    this.id = id;
    this.#job = job;
    this.#on_progress = onProgress;
    this.#transfer = transfer;
  }

  // The worker gets copies, or the arrays themselves if it may take them.
  messages() {
    const buffers = new Set();
    const own = (array) => {
      if (array === undefined) return undefined;
      const { buffer, byteLength } = array, is_whole = buffer instanceof ArrayBuffer && buffer.byteLength === byteLength;
      const given = this.#transfer && is_whole ? array : array.slice();
      buffers.add(given.buffer);
      return given;
    };
    const meshes = this.#job.meshes.map(({ indices, distinct, attributes, ...rest }) => ({ ...rest, indices: own(indices),
      distinct: own(distinct), attributes: attributes.map((attribute) => ({ ...attribute, array: own(attribute.array) })) }));
    return [[{ id: this.id, job: { ...this.#job, meshes } }, [...buffers]]];
  }
  progress(_, done, total) {
    this.#on_progress?.(done, total);
  }
  complete() {}
}

class Encoder {
  #workers;
  #module;

  constructor(options) {
    const wasm = options?.wasm;
    this.#module = wasm == null ? () => shared_module() : once(() => compile(wasm));
    this.#workers = new Workers({ workers: 1, ...options }, kEncoders);
  }

  async ready() {
    await this.#module();
  }
  async encodeMeshes(meshes, options) {
    const job = encode_job(meshes, options);
    return this.#workers.add((id) => new EncodeTask(id, job, options ?? {}), this.#module(), options?.signal);
  }
  async encodeMesh(mesh, options) {
    return (await this.encodeMeshes([mesh], options))[0];
  }
  async encodePoints(points, options) {
    return this.encodeMesh(points, { ...options, points: true });
  }
  dispose() {
    this.#workers.dispose();
  }
}

export const createEncoder = (options) => new Encoder(options);
