// The decoder of a renderer's device. Containers that are asked for together are one batch.
import { createGpuDecoder } from '../webgpu.js';

class BatchedDecoder {
  #decoder;
  #waiting = [];

  constructor(device) {
    this.#decoder = createGpuDecoder(device);
    this.#decoder.catch(() => {});  // decode() tells
  }

  /** Resolves to a mesh, or to the container's error. @param {Uint8Array} bytes @param {object[]} attributes */
  decode(bytes, attributes) {
    return new Promise((resolve, reject) => {
      if (this.#waiting.push({ bytes, attributes, resolve, reject }) === 1) setTimeout(() => this.#run());
    });
  }
  async #run() {
    const jobs = this.#waiting.splice(0);
    try {
      const decoder = await this.#decoder;
      const meshes = await decoder.decode(jobs.map(({ bytes }) => bytes), { attributes: jobs.map(({ attributes }) => attributes), wasm: false });
      for (const [i, { resolve }] of jobs.entries()) resolve(meshes[i]);
    } catch (error) {
      for (const { reject } of jobs) reject(error);
    }
  }
}

const decoders = new WeakMap();  // by device
export function decoder_of(device) {
  if (!decoders.has(device)) decoders.set(device, new BatchedDecoder(device));
  return decoders.get(device);
}
