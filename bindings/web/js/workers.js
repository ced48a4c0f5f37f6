// Workers, and the tasks that wait for them in order: each task goes to the next idle worker, or to several if it wants them.
// Workers start when tasks come, and end when they were idle for a while. Every task settles: if a worker fails, its task rejects,
// and all workers of the task are replaced.
import { error_from_data, PsplitError } from './error.js';
import { check_signal, on_abort } from './job.js';
import { is_node, node_module } from './node.js';

const kDefaultWorkers = 4;

// Starts a worker, which calls receive(message) or fail(error). `given`: the address of the worker's file, or a function that makes
// the worker, or undefined for the package's own.
async function start_worker({ node_worker, page_worker }, given, receive, fail) {
  const given_worker = (Type, options) => (typeof given === 'function' ? given() : new Type(new URL(given, globalThis.location?.href), options));
  if (is_node) {
    const { Worker } = await node_module('node:worker_threads');
    const worker = given == null ? node_worker(Worker) : given_worker(Worker);
    worker.on('message', receive);
    worker.on('error', fail);
    worker.on('messageerror', fail);
    worker.on('exit', () => fail(new Error('the worker ended')));
    // An idle worker does not keep the process alive. Jobs do: see Pool.
    worker.unref();
    return { post: (message, transfer) => worker.postMessage(message, transfer), end: () => worker.terminate(),
      hold: () => worker.ref(), let_go: () => worker.unref() };
  }
  const make = () => (given == null ? page_worker() : given_worker(globalThis.Worker, { type: 'module' }));
  const worker = make();
  worker.onmessage = ({ data }) => receive(data);
  worker.onerror = (event) => {
    event.preventDefault?.();
    fail(new Error(event.message ?? `${address_of(make)} cannot be loaded`));
  };
  worker.onmessageerror = () => fail(new Error('a message cannot be read'));
  return { post: (message, transfer) => worker.postMessage(message, transfer), end: () => worker.terminate(),
    hold() {}, let_go() {} };
}

// The address of a page's worker. Bundlers rewrite it inside `new Worker(...)`, so only a replacement of the class Worker gets to see it.
function address_of(make) {
  const { Worker } = globalThis;
  let address = 'the worker';
  try {
    globalThis.Worker = function (url) { address = url; };
    try {
      make();
    } finally {
      globalThis.Worker = Worker;
    }
  } catch {
    // The page does not let the class be replaced.
  }
  return address;
}

// Takes the place of a worker: this thread runs the jobs. Other tasks of the page come between them.
async function start_here({ job_runner }, receive) {
  const { make_runner } = await job_runner();
  let is_ended = false;
  const run = make_runner((message) => is_ended || receive(message));
  setTimeout(() => is_ended || receive({ is_up: true }));
  return { post: (message) => setTimeout(() => is_ended || run(message)), end: () => (is_ended = true), hold() {}, let_go() {} };
}

export class Workers {
  #kit;
  #most;
  #limit;  // of workers; less than #most if no more can be started
  #is_shared;
  #idle_ms;
  #worker;
  #may_run_here;
  #waiting = [];
  // { worker, is_up, is_here, task, timer, modules }; `worker` is null while it starts. If `is_here`, it is this thread, and the only one.
  // `modules` are the WebAssembly modules that it has received.
  #members = new Set();
  #next_id = 0;
  #is_disposed = false;

  /**
   * @param {object} options of createPool @param {object} kit the kind of workers: `worker()` returns what a caller configured, and
   * `does` is the verb for messages. files.js has the other members.
   */
  constructor(options, kit) {
    this.#kit = kit;
    const { workers, shared, worker, mainThread = true, idleMs = 10000 } = options ?? {};
    const cores = globalThis.navigator?.hardwareConcurrency ?? kDefaultWorkers;
    this.#most = this.#limit = workers ?? Math.max(1, Math.min(kDefaultWorkers, cores));
    if (!Number.isInteger(this.#most) || this.#most < 1)
      throw new PsplitError('the option `workers` is not a positive integer', 'invalid-input');
    const can_share = typeof SharedArrayBuffer !== 'undefined' && (is_node || globalThis.crossOriginIsolated === true);
    this.#is_shared = can_share && (shared ?? !is_node);
    this.#idle_ms = idleMs;
    this.#worker = worker ?? kit.worker();
    this.#may_run_here = mainThread;
  }

  get count() {
    return [...this.#members].filter(({ is_here }) => !is_here).length;
  }

  // Ends all workers. Jobs that are not done reject.
  dispose() {
    this.#is_disposed = true;
    const error = new PsplitError('the pool is disposed', 'aborted');
    for (const task of this.#waiting.splice(0)) task.reject(error);
    for (const member of [...this.#members]) {
      member.task?.reject(error);
      this.#drop(member);
    }
  }

  // Starts workers before their tasks come, until there are `count` or as many as there may be.
  begin(count) {
    while (!this.#is_disposed && this.#members.size < Math.min(count, this.#limit)) this.#start();
  }

  // Resolves to the result of the task that make_task(id) makes, by the WebAssembly module that `loading` resolves to. Workers start at the
  // same time as it is loaded.
  add(make_task, loading, signal) {
    loading.catch(() => {});  // the task tells
    return new Promise((resolve, reject) => {
      if (this.#is_disposed) return reject(new PsplitError('the pool is disposed', 'aborted'));
      check_signal(signal);
      if (signal?.aborted) return reject(new PsplitError('aborted', 'aborted'));
      const task = make_task(this.#next_id++);
      const abort = () => this.#cancel(task, new PsplitError('aborted', 'aborted'));
      const settle = (how) => (value) => {
        let_go();
        how(value);
      };
      task.resolve = settle(resolve), task.reject = settle(reject);
      const let_go = on_abort(signal, abort);
      this.#waiting.push(task);
      loading.then((module) => {
        task.module = module;
        this.#advance();
      }, (error) => this.#cancel(task, error));
      // Jobs that come together share the workers.
      queueMicrotask(() => this.#advance());
    });
  }

  // A worker cannot stop its work: it is replaced.
  #cancel(task, error) {
    const at = this.#waiting.indexOf(task);
    if (at >= 0) this.#waiting.splice(at, 1);
    task.reject(error);
    for (const member of task.members) this.#drop(member);
    this.#advance();
  }

  // Gives waiting tasks whose module is there to idle workers, and starts workers for the others.
  #advance() {
    while (this.#waiting.length > 0) {
      const members = [...this.#members], idle = members.filter(({ is_up, task }) => is_up && task === null);
      const starting = members.filter(({ is_up }) => !is_up).length;
      const free = idle.length + starting + Math.max(0, this.#limit - members.length);
      const task = this.#waiting.find(({ module }) => module !== undefined);
      const count = task && Math.min(task.most, Math.max(1, Math.floor(free / this.#waiting.length)));
      if (task === undefined || idle.length < count) {
        const wanted = this.#waiting.reduce((sum, { most }) => sum + most, 0);
        for (let more = wanted - idle.length - starting; more > 0 && this.#members.size < this.#limit; --more) this.#start();
        return;
      }
      this.#waiting.splice(this.#waiting.indexOf(task), 1);
      this.#give(task, idle.slice(0, count));
    }
  }

  async #start(is_here = false) {
    const member = { worker: null, is_up: false, is_here, task: null, timer: undefined, modules: [] };
    this.#members.add(member);
    try {
      const receive = (message) => this.#receive(member, message), fail = (error) => this.#fail(member, error);
      const worker = await (is_here ? start_here(this.#kit, receive) : start_worker(this.#kit, this.#worker, receive, fail));
      if (!this.#members.has(member)) return worker.end();
      member.worker = worker;
      worker.hold();
    } catch (error) {
      this.#fail(member, error);
    }
  }

  #give(task, members) {
    task.members = members;
    for (const member of members) {
      clearTimeout(member.timer);
      member.task = task;
      member.worker.hold();
    }
    try {
      for (const member of members) {
        if (member.modules.includes(task.module)) continue;
        member.worker.post({ module: task.module });
        member.modules.push(task.module);
      }
      const messages = task.messages(members.length, this.#is_shared);
      for (let part = members.length; part-- > 0;) {
        const [message, transfer] = messages[part], { worker, modules } = members[part];
        worker.post({ ...message, module_number: modules.indexOf(task.module) }, transfer);
      }
      if (task.source !== undefined) this.#feed(task, members[0]);
    } catch (error) {
      this.#cancel(task, error instanceof PsplitError ? error : new PsplitError(error.message, 'failed'));
    }
  }

  // Posts the bytes of a task as they arrive.
  async #feed(task, member) {
    try {
      for await (const chunk of task.source.chunks(0)) {
        if (member.task !== task) return;
        const copy = chunk.slice();
        member.worker.post({ id: task.id, chunk: copy }, [copy.buffer]);
      }
      if (member.task === task) member.worker.post({ id: task.id, chunk: null });
    } catch (error) {
      if (member.task === task) this.#cancel(task, error);
    }
  }

  #receive(member, { is_up, id, done, total, part, counts, result, error }) {
    if (is_up) {
      member.is_up = true;
      return this.#rest([member]);
    }
    const { task } = member;
    if (task === null || task.id !== id) return;
    try {
      if (part !== undefined) return task.deliver(part, counts);
      if (done !== undefined) return task.progress(member, done, total);
      if (result !== undefined) task.complete(result);
    } catch (cause) {
      return this.#cancel(task, cause);  // of the caller's functions
    }
    // Helpers have no error of the job. If one fails otherwise, the lead would wait for it.
    if (member !== task.members[0]) return this.#cancel(task, error_from_data(error));
    for (const other of task.members) other.task = null;
    if (error === undefined) task.resolve(result);
    else task.reject(error_from_data(error));
    this.#rest(task.members);
  }

  // The members have no task: they take the next one, or end after a while.
  #rest(members) {
    for (const { worker } of members) worker.let_go();
    this.#advance();
    for (const member of members) {
      if (member.task !== null) continue;
      clearTimeout(member.timer);
      member.timer = setTimeout(() => this.#drop(member), this.#idle_ms);
      member.timer.unref?.();
    }
  }

  // A worker failed, or cannot be started. If no worker is left, this thread runs the tasks that wait, or they have the same
  // error.
  #fail(member, error) {
    if (!this.#members.has(member)) return;
    const failure = error instanceof PsplitError ? error : new PsplitError(`worker: ${error?.message ?? error}`, 'failed');
    const { is_up, is_here, task } = member;
    this.#drop(member);
    if (task !== null) return this.#cancel(task, failure);
    if (!is_up && this.#members.size > 0) this.#limit = this.#members.size;
    if (!is_up && this.#members.size === 0 && this.#may_run_here && failure !== error && !is_here && this.#waiting.length > 0) {
      console.warn(`psplit: no worker can be started, so this thread ${this.#kit.does} (${failure.message})`);
      this.#limit = 1;
      return void this.#start(true);
    }
    if (!is_up && this.#members.size === 0) for (const waiting of this.#waiting.splice(0)) waiting.reject(failure);
    this.#advance();
  }

  #drop(member) {
    if (!this.#members.delete(member)) return;
    clearTimeout(member.timer);
    member.worker?.end();
    member.task = null;
    if (this.#members.size === 0) this.#limit = this.#most;
  }
}
