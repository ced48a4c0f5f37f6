// The worker of a pool: runs jobs one after the other. The first message has the compiled module.
import { error_to_data } from './error.js';
import { buffers_of, Decoder } from './instance.js';

const is_node = typeof process === 'object' && process.versions?.node !== undefined;
const port = is_node
  ? (await import(/* webpackIgnore: true */ /* @vite-ignore */ 'node:worker_threads')).parentPort : globalThis;
const post = (message, transfer) => port.postMessage(message, transfer);

let decoder;

function receive({ module, id, job }) {
  if (module !== undefined) {
    decoder = new Decoder(module);
    return;
  }
  try {
    const result = decoder.run(job);
    post({ id, result }, buffers_of(result));
  } catch (error) {
    post({ id, error: error_to_data(error) });
  }
}

if (is_node) port.on('message', receive);
else port.onmessage = ({ data }) => receive(data);
