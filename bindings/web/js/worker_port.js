// Connects a worker's runner with the thread that started the worker.
import { is_node, node_module } from './node.js';

/** `make_runner(post)` returns what receives messages. */
export function serve(make_runner) {
  let port = globalThis;
  const receive = make_runner((message, transfer) => port.postMessage(message, transfer));
  // No `await` on the top level: bundlers may make a classic script of a worker.
  if (is_node) {
    node_module('node:worker_threads').then(({ parentPort }) => {
      port = parentPort;
      port.on('message', receive);
      port.postMessage({ is_up: true });
    });
  } else {
    port.onmessage = ({ data }) => receive(data);
    port.postMessage({ is_up: true });
  }
}
