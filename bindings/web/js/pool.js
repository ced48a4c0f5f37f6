// A pool of workers that decode. Large jobs go to several workers.
import { ArrivingAsset } from './arriving_asset.js';
import { ArrivingBytes } from './arriving.js';
import { PsplitError } from './error.js';
import { choice, job_runner, node_worker, page_worker } from './files.js';
import { head_begin, is_condensed, kHeaderBytes } from './head.js';
import { make_job, or_abort, signal_of } from './job.js';
import { configured, Modules } from './module.js';
import { Task } from './task.js';
import { Workers } from './workers.js';

// A container of which this is all has so few patches that it is decoded when it is whole.
const kLeastBytes = 16384;

const kDecoders = { job_runner, node_worker, page_worker, does: 'decodes', worker: () => configured.worker };

// The first bytes of a container that arrives, to the first of its head.
async function front_of(source) {
  await source.until(kHeaderBytes);
  const end = head_begin(source.copy(0, kHeaderBytes)) + 1;
  await source.until(end);
  return source.copy(0, end);
}

class Pool {
  #workers;
  #modules;
  #loading = new Set();  // functions that end what waits for a module to choose patches

  constructor(options) {
    this.#modules = new Modules(options?.wasm, options?.condensedWasm);
    this.#workers = new Workers(options, kDecoders);
  }

  get workerCount() {
    return this.#workers.count;
  }

  async ready(options) {
    await this.#modules.get(options?.condensed === true);
  }
  // Starts workers for `count` containers before their bytes arrive.
  begin(count) {
    this.#workers.begin(count);
  }
  async decodeDraco(data, options) {
    return this.#add(make_job('draco', data, options), options ?? {});
  }
  async decodeContainer(data, options) {
    return this.#add(make_job('container', data, options), options ?? {});
  }
  async decodePatches(data, options) {
    if (typeof options?.onPart !== 'function') throw new PsplitError('the option `onPart` is not a function', 'invalid-input');
    return this.#add(make_job('container', data, options), options);
  }

  async decodeStream(stream, options) {
    return this.#decode_stream(stream, options ?? {});
  }
  // `chosen`: numbers of patches. The stream then has what a job with them gets, in chunks.
  async #decode_stream(stream, options, chosen) {
    const job = make_job('container', new Uint8Array(), options), { signal, end } = signal_of(options.signal);
    try {
      this.#workers.begin(1);
      const source = new ArrivingBytes(stream, signal), module = this.#modules.get(is_condensed(await front_of(source)));
      module.catch(() => {});  // the task tells
      if (chosen === undefined) await source.until(kLeastBytes);
      return await this.#add({ ...job, source, chosen }, options, module);
    } finally {
      end();  // after an error, the stream
    }
  }

  // Decodes the container in a buffer view of an ArrivingAsset, or patches of it, of primitive `place`. `check` gets the counts of
  // the whole mesh.
  async decodeView(asset, view, { choose, place, check, ...options }) {
    if (choose != null) {
      const { empty_mesh, planned } = await choice();
      const plan = await planned((front) => this.#module_for(front, options.signal), await asset.place(view), choose, (counts) => (check(counts), place), options.signal);
      if (plan?.chosen.length === 0) return empty_mesh(options.attributes ?? []);
      if (plan !== null) return this.#decode_stream(plan.parts, options, plan.chosen);
    }
    const mesh = await this.#decode_stream(asset.chunks(view), options);
    check(mesh);
    return mesh;
  }

  async decodeUrl(url, options) {
    const { signal: outer, onProgress, onPart, choose, ...rest } = options ?? {}, { signal, end } = signal_of(outer);
    try {
      const asset = await ArrivingAsset.open(url, signal, undefined, choose), counts = [];
      const progress = (i, done, total) => {
        counts[i] = { done, total };
        const sum = (name) => counts.reduce((all, of) => all + of[name], 0);
        onProgress(sum('done'), sum('total'));
      };
      const containers = asset.containers();
      this.#workers.begin(containers.length);
      const primitives = await Promise.all(containers.map(async (container, i) => {
        const { view, attributes, uses: [place] } = container;
        const mesh = await this.decodeView(asset, view, { ...rest, ...(attributes && { attributes }), signal, choose, place,
          check: (of) => asset.check(container, of),
          onProgress: onProgress && ((done, total) => progress(i, done, total)),
          onPart: onPart && ((part, of) => onPart(part, of, place)) }).catch((error) => { throw asset.placed(error, place); });
        return container.uses.map((use) => ({ ...use, ...mesh }));
      }));
      return { json: asset.json, primitives: primitives.flat() };
    } finally {
      end();  // ends fetches that are not needed, and after an error the other containers
    }
  }

  // Ends all workers. Jobs that are not done reject.
  dispose() {
    this.#workers.dispose();
    for (const end of this.#loading) end();
  }

  async #module_for(front, outer) {
    const { signal, end } = signal_of(outer);
    this.#loading.add(end);
    try {
      return await or_abort(this.#modules.get(is_condensed(front)), signal);
    } finally {
      this.#loading.delete(end);
      end();
    }
  }
  // `module`: a promise of what decodes it, if its bytes arrive.
  async #add(job, options, module) {
    const task = new Task(job, options), loading = module ?? this.#modules.get(job.kind === 'container' && is_condensed(job.bytes));
    return this.#workers.add((id) => Object.assign(task, { id }), loading, options.signal);
  }
}

export const createPool = (options) => new Pool(options);
