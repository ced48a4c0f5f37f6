// Decodes Draco streams, and the containers of the glTF extension PSPLIT_mesh_draco_patches.
import { Decoder } from './instance.js';
import { make_job } from './job.js';
import { shared_module } from './module.js';

export { PsplitError } from './error.js';
export { configure } from './module.js';
export { createPool } from './pool.js';

let decoder;

async function run(job) {
  const module = await shared_module();
  if (decoder?.module !== module) decoder = new Decoder(module);
  return decoder.run(job);
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
