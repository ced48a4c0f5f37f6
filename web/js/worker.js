// The worker of a pool: runs jobs one after the other. The first message has the compiled module.
import { error_to_data } from './error.js';
import { buffers_of, Decoder } from './instance.js';
import { is_node, node_module } from './node.js';

let port = globalThis;
const post = (message, transfer) => port.postMessage(message, transfer);

let decoder;

async function receive({ module, id, job }) {
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
}

// No `await` on the top level: bundlers may make a classic script of this file.
if (is_node) {
  node_module('node:worker_threads').then(({ parentPort }) => {
    port = parentPort;
    port.on('message', receive);
  });
} else {
  port.onmessage = ({ data }) => receive(data);
}
