// A Worker of the web, as far as DRACOLoader needs it.
import { resolveObjectURL } from 'node:buffer';
import { Worker as NodeWorker } from 'node:worker_threads';

export class BlobWorker {
  #worker = null;
  #waiting = [];
  constructor(url) {
    resolveObjectURL(url).text().then((source) => {
      const prelude = `const port = require('node:worker_threads').parentPort; globalThis.self = globalThis;
        globalThis.postMessage = (message, transfer) => port.postMessage(message, transfer);
        port.on('message', (data) => onmessage({ data }));`;
      this.#worker = new NodeWorker(`${prelude}\n${source}`, { eval: true });
      this.#worker.on('message', (data) => this.onmessage({ data }));
      for (const [message, transfer] of this.#waiting) this.#worker.postMessage(message, transfer);
    });
  }
  postMessage(message, transfer) {
    if (this.#worker === null) this.#waiting.push([message, transfer]);
    else this.#worker.postMessage(message, transfer);
  }
  terminate() {
    this.#worker?.terminate();
  }
}
