// The attributes of a container as buffers of three's WebGPURenderer, decoded on its device: the renderer draws from the buffers that the
// shaders write. three has no public way to hand it a buffer. Its backend keeps a buffer for each attribute, and makes one only for an
// attribute that has no buffer yet (WebGPUAttributeUtils.createAttribute).
import { BufferAttribute } from 'three';
import { PsplitError } from '../error.js';
import { or_abort } from '../job.js';
import { array_of } from '../types.js';
import { decoder_of } from '../webgpu/batched_decoder.js';

const unsupported = (message) => new PsplitError(message, 'unsupported');

// three widens single numbers of 8 and 16 bits when it makes a buffer, and needs the bounds of a mesh whose positions it cannot read.
function check_columns({ columns, attributes, requests }) {
  if (attributes.some(({ components, Type }) => components === 1 && Type.BYTES_PER_ELEMENT < 4)) throw unsupported('single numbers of 8 or 16 bits');
  const { accessor } = attributes[requests.findIndex(({ name }) => name === 'POSITION')] ?? columns[0];
  if (accessor.min === undefined || accessor.max === undefined) throw unsupported('positions without bounds');
}

function attribute_of(backend, buffer, Type, components, normalized, count) {
  // Nothing reads the array, except for its type.
  const attribute = Object.assign(new BufferAttribute(new Type(), components, normalized), { count });
  backend.get(attribute).buffer = buffer;
  return attribute;
}

/**
 * Decodes a container for a renderer. Rejects if the shaders do not decode it, if the renderer has no WebGPU, or if three would change
 * the values in the buffers.
 * @param {WebGPURenderer} renderer
 * @param {import('./container.js').Container} container
 * @param {() => Promise<ArrayBuffer | Uint8Array>} bytes_of
 * @param {AbortSignal} signal
 * @returns {Promise<{ mesh: GpuMesh, attributes: BufferAttribute[] }>} `attributes` in the order of the container's columns
 */
export async function decode_for(renderer, container, bytes_of, signal) {
  check_columns(container);
  await or_abort(renderer.init?.(), signal);
  const { backend } = renderer;
  if (backend?.isWebGPUBackend !== true || typeof backend.get !== 'function' || backend.device == null)
    throw unsupported('the renderer has no WebGPU device');
  const { device } = backend, bytes = await bytes_of();
  const mesh = await or_abort(decoder_of(device).decode(bytes, container.requests), signal);
  if (mesh instanceof Error) throw mesh;
  try {
    container.check(mesh);
    const { indices, pointCount } = mesh;
    return { mesh, attributes: [attribute_of(backend, indices.buffer, Uint32Array, 1, false, indices.count),
      ...mesh.attributes.map(({ buffer, type, componentCount, normalized }) =>
        attribute_of(backend, buffer, array_of(type), componentCount, normalized, pointCount))] };
  } catch (error) {
    mesh.destroy();
    throw error;
  }
}
