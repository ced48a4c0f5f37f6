// The files that psplit/encode loads. Bundlers find them by these expressions, so they must stay as they are.

/** The address of psplit_encoder.wasm. */
export const wasm_file = () => new URL('./psplit_encoder.wasm', import.meta.url);
/** A worker of a page. */
export const page_worker = () => new Worker(new URL('./encode_worker.js', import.meta.url), { type: 'module' });
/** What runs jobs without a worker: pages load it when they need it. */
export const job_runner = () => import('./encode_runner.js');
/** A worker of Node.js; NodeWorker is the class of node:worker_threads. */
export const node_worker = (NodeWorker) => new NodeWorker(
  new URL(/* webpackIgnore: true */ /* @vite-ignore */ './encode_worker.js', import.meta.url));
