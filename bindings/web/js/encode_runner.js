// Runs the jobs of an encoder, one after the other: in a worker, or on the encoder's own thread if no worker can be started.
import { buffers_of, encode_meshes } from './encode_job.js';
import { error_to_data } from './error.js';

/**
 * Returns the function that receives the encoder's messages. The first one has the compiled module, and all others have jobs.
 * @param {(message: object, transfer?: Transferable[]) => void} post to the encoder
 */
export function make_runner(post) {
  let encoder;
  return ({ module, id, job }) => {
    if (module !== undefined) return void (encoder = module);
    try {
      const result = encode_meshes(encoder, job, (done, total) => post({ id, done, total }));
      post({ id, result }, buffers_of(result));
    } catch (error) {
      post({ id, error: error_to_data(error) });
    }
  };
}
