// The package's other files. Bundlers find them by these expressions, so they must stay as they are. psplit/inline has another
// version of this file, in which the files are part of the code.

/** The address or the bytes of psplit.wasm. */
export const wasm_file = () => new URL('./psplit.wasm', import.meta.url);
/** Likewise for psplit_condensed.wasm, which is loaded for the first container of condensed patches. */
export const condensed_wasm_file = () => new URL('./psplit_condensed.wasm', import.meta.url);
/** A worker of a page. */
export const page_worker = () => new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
/** What runs jobs without a worker: pages load it when they need it. */
export const job_runner = () => import('./job_runner.js');
/** What decodes chosen patches of a file: pages load it when they need it. */
export const choice = () => import('./choice.js');
/** A worker of Node.js; NodeWorker is the class of node:worker_threads. */
export const node_worker = (NodeWorker) => new NodeWorker(
  new URL(/* webpackIgnore: true */ /* @vite-ignore */ './worker.js', import.meta.url));
