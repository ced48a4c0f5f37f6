// Runs the jobs of a pool, one after the other: in a worker, or on the pool's own thread if no worker can be started.
import { error_to_data } from './error.js';
import { buffers_of, Decoder } from './instance.js';

// The chunks of a job that arrives.
class Inbox {
  #chunks = [];
  #wake = () => {};

  constructor(id) {
    this.id = id;
  }
  get has_more() {
    return this.#chunks[0] != null;
  }
  add(chunk) {
    this.#chunks.push(chunk);
    this.#wake();
  }
  async next() {
    if (this.#chunks.length === 0) await new Promise((resolve) => (this.#wake = resolve));
    return this.#chunks.shift();
  }
}

/**
 * Returns the function that receives the pool's messages. Compiled modules come before the jobs that need them, which have their numbers.
 * @param {(message: object, transfer?: Transferable[]) => void} post to the pool
 */
export function make_runner(post) {
  const decoders = [];
  let inbox = null;
  return async ({ module, module_number, id, job, chunk }) => {
    if (chunk !== undefined) return inbox?.id === id ? inbox.add(chunk) : undefined;
    if (module !== undefined) return void decoders.push(new Decoder(module));
    try {
      const decoder = decoders[module_number];
      const report = (message) => post({ id, ...message }, message.part === undefined ? [] : buffers_of(message.part));
      inbox = job.arrives ? new Inbox(id) : null;
      const is_part = job.ports !== undefined || job.arrives;
      const result = await (is_part ? decoder.run_part(job, report, inbox) : decoder.run(job, report));
      if (result !== undefined) post({ id, result }, buffers_of(result));
    } catch (error) {
      post({ id, error: error_to_data(error) });
    }
  };
}
