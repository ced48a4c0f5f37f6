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
 * Returns the function that receives the pool's messages. The first one has the compiled module.
 * @param {(message: object, transfer?: Transferable[]) => void} post to the pool
 */
export function make_runner(post) {
  let decoder, other_decoder, inbox = null;  // the other one is of jobs with `has_module`
  return async ({ module, other_module, id, job, chunk }) => {
    if (chunk !== undefined) return inbox?.id === id ? inbox.add(chunk) : undefined;
    if (module !== undefined) {
      decoder = new Decoder(module);
      post({ is_up: true });
      return;
    }
    if (other_module !== undefined) {
      other_decoder = new Decoder(other_module);
      return;
    }
    try {
      const used = job.has_module ? other_decoder : decoder;
      const report = (message) => post({ id, ...message }, message.part === undefined ? [] : buffers_of(message.part));
      inbox = job.arrives ? new Inbox(id) : null;
      const is_part = job.ports !== undefined || job.arrives;
      const result = await (is_part ? used.run_part(job, report, inbox) : used.run(job, report));
      if (result !== undefined) post({ id, result }, buffers_of(result));
    } catch (error) {
      post({ id, error: error_to_data(error) });
    }
  };
}
