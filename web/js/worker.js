// The worker of a pool.
import { make_runner } from './job_runner.js';
import { is_node, node_module } from './node.js';

let port = globalThis;
const receive = make_runner((message, transfer) => port.postMessage(message, transfer));

// No `await` on the top level: bundlers may make a classic script of this file.
if (is_node) {
  node_module('node:worker_threads').then(({ parentPort }) => {
    port = parentPort;
    port.on('message', receive);
  });
} else {
  port.onmessage = ({ data }) => receive(data);
}
