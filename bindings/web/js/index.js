// Decodes Draco streams, and the containers of the glTF extension PSPLIT_mesh_draco_patches.
import { is_condensed } from './head.js';
import { decoder_of } from './instance.js';
import { make_job } from './job.js';
import { shared_modules } from './module.js';

export { PsplitError } from './error.js';
export { configure } from './module.js';
export { createPool } from './pool.js';

async function run(job) {
  return decoder_of(await shared_modules.get(job.kind === 'container' && is_condensed(job.bytes))).run(job);
}

export async function ready(options) {
  await shared_modules.get(options?.condensed === true);
}

export async function decodeDraco(data, options) {
  return run(make_job('draco', data, options));
}

export async function decodeContainer(data, options) {
  return run(make_job('container', data, options));
}
