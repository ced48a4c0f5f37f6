// A decoded container as buffers of Babylon.js' WebGPU engine, on whose device shaders decoded it: the engine draws from the buffers that
// these write.
import { PsplitError } from '../error.js';
import { or_abort } from '../job.js';
import { decoder_of } from '../webgpu/batched_decoder.js';

// The engine's own kind of buffer, with a buffer of the decoder. Babylon.js exports no way to make one without a copy: the engine makes
// one of its own, which is then replaced.
function wrapped(engine, buffer) {
  const made = engine.createVertexBuffer(new Uint8Array(4));
  made.underlyingResource.destroy();
  return Object.assign(made, { buffer, capacity: buffer.size });
}

/** The buffers of a container's mesh, until Babylon.js takes them. */
export class GpuBuffers {
  #engine;
  #indices;
  #left;  // attributes that were not taken, by name
  #is_indexed = false;  // some geometry has the indices

  constructor(engine, mesh) {
    this.#engine = engine;
    this.#indices = wrapped(engine, mesh.indices.buffer);
    this.#left = new Map(mesh.attributes.map((attribute) => [attribute.name, attribute]));
    this.mesh = mesh;
  }

  /** What Babylon.js' Buffer takes in place of an array, or undefined if it was taken. Calls set_stride(bytes) before. */
  take(name, set_stride) {
    const attribute = this.#left.get(name);
    if (attribute === undefined) return undefined;
    this.#left.delete(name);
    set_stride(attribute.stride);
    return wrapped(this.#engine, attribute.buffer);
  }
  /** Gives a geometry, which has its attributes, the indices. */
  index(geometry) {
    const { indices, pointCount } = this.mesh;
    if (this.#is_indexed) ++this.#indices.references;  // Babylon.js releases it for each geometry
    this.#is_indexed = true;
    geometry.setIndexBuffer(this.#indices, pointCount, indices.count, true);
    for (const { buffer } of this.#left.values()) buffer.destroy();  // Babylon.js reads no such attributes
    this.#left.clear();
  }
}

// Why Babylon.js needs the arrays of a container's mesh, or undefined.
function why_arrays(loader, { is_draco, primitive, stored, accessors }, source) {
  if (is_draco) return 'stock Draco';
  if (source?.choose) return 'chosen patches';
  if (primitive.targets !== undefined || stored.attributes.some(({ name }) => name.startsWith('WEIGHTS_'))) return 'a mesh that is skinned or has morph targets';
  const { min, max } = accessors.get('POSITION') ?? {};
  return min === undefined || max === undefined || loader.parent?.alwaysComputeBoundingBox ? 'positions without bounds' : undefined;
}

async function decode(engine, attributes, bytes_of, check, signal) {
  const device = engine._device;
  if (!engine.isWebGPU || device == null) throw new PsplitError('the engine has no WebGPU device', 'unsupported');
  const mesh = await or_abort(decoder_of(device).decode(await bytes_of(), attributes), signal);
  if (mesh instanceof Error) throw mesh;
  try {
    check(mesh);
    return new GpuBuffers(engine, mesh);
  } catch (error) {
    mesh.destroy();
    throw error;
  }
}

/**
 * Decodes a container on the device of the engine with which its mesh is loaded.
 * @param {GLTFLoader} loader Babylon.js'
 * @param {object} container of PatchesLoader; gets `why` if it is not decoded here
 * @param {object | undefined} source of a container that arrives
 * @param {() => Promise<Uint8Array>} bytes_of
 * @param {(mesh: GpuMesh) => void} check throws if the mesh is not what the asset says
 * @param {AbortSignal} signal
 * @returns {Promise<GpuBuffers | null>} null if Babylon.js needs arrays, if the shaders do not decode the container, or if there is no WebGPU
 */
export async function decode_for(loader, container, source, bytes_of, check, signal) {
  try {
    const why = why_arrays(loader, container, source);
    if (why !== undefined) throw new PsplitError(why, 'unsupported');
    const buffers = await decode(loader.babylonScene.getEngine(), container.stored.attributes, bytes_of, check, signal), { patchCount } = buffers.mesh;
    // The loader reads no indices: the geometry gets them later.
    container.accessors.get(undefined)._data = Promise.resolve(new Uint32Array());
    source?.onProgress?.(patchCount, patchCount);
    return buffers;
  } catch (error) {
    if (signal.aborted) throw new PsplitError('aborted', 'aborted');
    container.why = error.message;
    return null;
  }
}
