// Decodes Draco streams, and the containers of the glTF extension PSPLIT_mesh_draco_patches.
import { Decoder } from './instance.js';
import { make_job } from './job.js';
import { module_for, shared_module } from './module.js';

export { PsplitError } from './error.js';
export { configure } from './module.js';
export { createPool } from './pool.js';

const decoders = [];  // of psplit.wasm, and of psplit_condensed.wasm

async function run(job) {
  const shared = await shared_module(), module = job.kind === 'draco' ? shared : await module_for(job.bytes, shared);
  const at = module === shared ? 0 : 1;
  if (decoders[at]?.module !== module) decoders[at] = new Decoder(module);
  return decoders[at].run(job);
}

export async function ready() {
  await shared_module();
}

export async function decodeDraco(data, options) {
  return run(make_job('draco', data, options));
}

export async function decodeContainer(data, options) {
  return run(make_job('container', data, options));
}
