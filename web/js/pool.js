// A pool of workers. Jobs wait in order; each goes to the next idle worker. Workers start when jobs come, and end
// when they were idle for a while. Every job settles: a worker that fails is replaced, and its job rejects.
import { error_from_data, PsplitError } from './error.js';
import { node_worker, page_worker } from './files.js';
import { make_job } from './job.js';
import { compile_module, shared_module } from './module.js';
import { is_node, node_module } from './node.js';

const kDefaultWorkers = 4;

// Starts a worker, which calls receive(message) or fail(error).
async function start_worker(receive, fail) {
  if (is_node) {
    const { Worker } = await node_module('node:worker_threads');
    const worker = node_worker(Worker);
    worker.on('message', receive);
    worker.on('error', fail);
    worker.on('messageerror', fail);
    worker.on('exit', () => fail(new Error('the worker ended')));
    // An idle worker does not keep the process alive. Jobs do: see Pool.
    worker.unref();
    return { post: (message, transfer) => worker.postMessage(message, transfer), end: () => worker.terminate(),
      hold: () => worker.ref(), let_go: () => worker.unref() };
  }
  const worker = page_worker();
  worker.onmessage = ({ data }) => receive(data);
  worker.onerror = (event) => {
    event.preventDefault?.();
    fail(new Error(event.message ?? 'the worker cannot be loaded'));
  };
  worker.onmessageerror = () => fail(new Error('a message cannot be read'));
  return { post: (message, transfer) => worker.postMessage(message, transfer), end: () => worker.terminate(),
    hold() {}, let_go() {} };
}

class Pool {
  #most;
  #idle_ms;
  #wasm;
  #module;
  #waiting = [];
  #members = new Set();  // { worker, task, timer }; `worker` is null while it starts
  #next_id = 0;
  #is_disposed = false;

  constructor({ workers, wasm, idleMs = 10000 } = {}) {
    const cores = globalThis.navigator?.hardwareConcurrency ?? kDefaultWorkers;
    this.#most = workers ?? Math.max(1, Math.min(kDefaultWorkers, cores));
    if (!Number.isInteger(this.#most) || this.#most < 1)
      throw new PsplitError('the option `workers` is not a positive integer', 'invalid-input');
    this.#idle_ms = idleMs;
    this.#wasm = wasm;
  }

  get workerCount() {
    return this.#members.size;
  }

  async ready() {
    await this.#load();
  }
  async decodeDraco(data, options = {}) {
    return this.#add(make_job('draco', data, options), options);
  }
  async decodeContainer(data, options = {}) {
    return this.#add(make_job('container', data, options), options);
  }

  // Ends all workers. Jobs that are not done reject.
  dispose() {
    this.#is_disposed = true;
    for (const task of this.#waiting.splice(0)) task.reject(new PsplitError('the pool is disposed', 'aborted'));
    for (const member of [...this.#members]) this.#drop(member, new PsplitError('the pool is disposed', 'aborted'));
  }

  #load() {
    this.#module ??= (this.#wasm === undefined ? shared_module() : compile_module(this.#wasm)).catch((error) => {
      this.#module = undefined;
      throw error;
    });
    return this.#module;
  }

  #add(job, { signal, transfer = false }) {
    return new Promise((resolve, reject) => {
      const aborted = () => new PsplitError('aborted', 'aborted');
      if (this.#is_disposed) return reject(new PsplitError('the pool is disposed', 'aborted'));
      if (signal?.aborted) return reject(aborted());
      const task = { id: this.#next_id++, job, transfer };
      const abort = () => {
        const at = this.#waiting.indexOf(task);
        if (at >= 0) this.#waiting.splice(at, 1);
        task.reject(aborted());
        // A worker cannot stop its work: it is replaced.
        const member = [...this.#members].find((other) => other.task === task);
        if (member !== undefined) this.#drop(member, aborted());
        this.#advance();
      };
      const settle = (how) => (value) => {
        signal?.removeEventListener('abort', abort);
        how(value);
      };
      task.resolve = settle(resolve), task.reject = settle(reject);
      signal?.addEventListener('abort', abort);
      this.#waiting.push(task);
      this.#advance();
    });
  }

  // Gives waiting tasks to idle workers, and starts workers for the others.
  #advance() {
    for (const member of this.#members) {
      if (this.#waiting.length === 0) return;
      if (member.worker !== null && member.task === null) this.#give(member, this.#waiting.shift());
    }
    const starting = [...this.#members].filter((member) => member.worker === null).length;
    for (let more = this.#waiting.length - starting; more > 0 && this.#members.size < this.#most; --more) this.#start();
  }

  async #start() {
    const member = { worker: null, task: null, timer: undefined };
    this.#members.add(member);
    try {
      const module = await this.#load();
      const worker = await start_worker((message) => this.#receive(member, message), (error) => this.#fail(member, error));
      if (!this.#members.has(member)) return worker.end();
      member.worker = worker;
      worker.post({ module });
      this.#rest(member);
    } catch (error) {
      this.#fail(member, error);
    }
  }

  #give(member, task) {
    clearTimeout(member.timer);
    member.task = task;
    member.worker.hold();
    const { bytes } = task.job, is_whole = bytes.byteLength === bytes.buffer.byteLength;
    try {
      member.worker.post({ id: task.id, job: task.job }, task.transfer && is_whole ? [bytes.buffer] : []);
    } catch (error) {
      member.task = null;
      task.reject(new PsplitError(error.message, 'failed'));
      this.#rest(member);
    }
  }

  #receive(member, { id, result, error }) {
    const { task } = member;
    if (task === null || task.id !== id) return;
    member.task = null;
    if (error === undefined) task.resolve(result);
    else task.reject(error_from_data(error));
    this.#rest(member);
  }

  // The member has no task: takes the next one, or ends after a while.
  #rest(member) {
    member.worker.let_go();
    this.#advance();
    if (member.task !== null) return;
    member.timer = setTimeout(() => this.#drop(member), this.#idle_ms);
    member.timer.unref?.();
  }

  // A worker failed, or none can be started. If no worker is left, the tasks that wait have the same error.
  #fail(member, error) {
    if (!this.#members.has(member)) return;
    const failure = error instanceof PsplitError ? error : new PsplitError(`worker: ${error?.message ?? error}`, 'failed');
    const never_worked = member.worker === null || member.task === null;
    this.#drop(member, failure);
    if (never_worked && this.#members.size === 0)
      for (const task of this.#waiting.splice(0)) task.reject(failure);
    this.#advance();
  }

  #drop(member, error) {
    if (!this.#members.delete(member)) return;
    clearTimeout(member.timer);
    member.worker?.end();
    const { task } = member;
    member.task = null;
    task?.reject(error);
  }
}

export const createPool = (options) => new Pool(options);
