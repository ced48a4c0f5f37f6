// Takes the place of bindings/web/js/files.js in psplit/inline: the module and the worker's code are texts of the same file.
import { wasm_text, worker_text } from './contents.js';
import { empty_mesh, open_ranged, planned } from './choice.js';
import { make_runner } from './job_runner.js';

let bytes, worker_address;

// Each character is a byte, plus 256 if the byte's own character would need an escape in a literal or in HTML.
export function wasm_file() {
  if (bytes !== undefined) return bytes;
  bytes = new Uint8Array(wasm_text.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = wasm_text.charCodeAt(i);
  return bytes;
}
export const condensed_wasm_file = wasm_file;  // it decodes all

// The policy of a page may forbid this: it has to have `worker-src blob:`.
export function page_worker() {
  worker_address ??= URL.createObjectURL(new Blob([worker_text], { type: 'text/javascript' }));
  return new Worker(worker_address, { type: 'module' });
}
export const job_runner = async () => ({ make_runner });
export const choice = async () => ({ empty_mesh, open_ranged, planned });
export const node_worker = (NodeWorker) => new NodeWorker(new URL(`data:text/javascript,${encodeURIComponent(worker_text)}`));
