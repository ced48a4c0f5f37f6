// The worker of a pool: runs jobs one after the other. The first message has the compiled module.
import { error_to_data } from './error.js';
import { buffers_of, Decoder } from './instance.js';
import { is_node, node_module } from './node.js';

let port = globalThis;
const post = (message, transfer) => port.postMessage(message, transfer);

let decoder;

// The chunks of a job that arrives.
class Inbox {
  #chunks = [];
  #wake = () => {};

  add(chunk) {
    this.#chunks.push(chunk);
    this.#wake();
  }
  async next() {
    if (this.#chunks.length === 0) await new Promise((resolve) => (this.#wake = resolve));
    return this.#chunks.shift();
  }
}
let inbox = null;

async function receive({ module, id, job, chunk }) {
  if (chunk !== undefined) return inbox?.id === id ? inbox.add(chunk) : undefined;
  if (module !== undefined) {
    decoder = new Decoder(module);
    post({ is_up: true });
    return;
  }
  try {
    const report = (message) => post({ id, ...message }, message.part === undefined ? [] : buffers_of(message.part));
    inbox = job.arrives ? Object.assign(new Inbox(), { id }) : null;
    const is_part = job.ports !== undefined || job.arrives;
    const result = await (is_part ? decoder.run_part(job, report, () => inbox.next()) : decoder.run(job, report));
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
