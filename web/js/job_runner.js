// Runs the jobs of a pool, one after the other: in a worker, or on the pool's own thread if no worker can be started.
import { error_to_data } from './error.js';
import { buffers_of, Decoder } from './instance.js';

/**
 * Returns the function that receives the pool's messages. The first one has the compiled module.
 * @param {(message: object, transfer?: Transferable[]) => void} post to the pool
 */
export function make_runner(post) {
  let decoder;
  return async ({ module, id, job }) => {
    if (module !== undefined) {
      decoder = new Decoder(module);
      post({ is_up: true });
      return;
    }
    try {
      const report = (message) => post({ id, ...message }, message.part === undefined ? [] : buffers_of(message.part));
      const result = await (job.ports === undefined ? decoder.run(job, report) : decoder.run_part(job, report));
      if (result !== undefined) post({ id, result }, buffers_of(result));
    } catch (error) {
      post({ id, error: error_to_data(error) });
    }
  };
}
