// The arguments of the public functions, checked, as the job that a decoder runs.
import { PsplitError } from './error.js';
import { kTypes } from './types.js';

function bytes_of(data) {
  if (data instanceof Uint8Array) return data;
  if (ArrayBuffer.isView(data)) return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  const is_shared = typeof SharedArrayBuffer !== 'undefined' && data instanceof SharedArrayBuffer;
  if (data instanceof ArrayBuffer || is_shared) return new Uint8Array(data);
  throw new PsplitError('the data is not an ArrayBuffer or a view of one', 'invalid-input');
}

function check_attributes(kind, attributes) {
  if (attributes === undefined) return undefined;
  if (!Array.isArray(attributes)) throw new PsplitError('the option `attributes` is not an array', 'invalid-input');
  return attributes.map(({ name, uniqueId, semantic, type, componentCount, normalized }) => {
    const request = { uniqueId, name: String(name ?? semantic ?? `attribute ${uniqueId}`) };
    const is_count = (value, most) => Number.isInteger(value) && value >= 0 && value <= most;
    if (kind === 'draco' && uniqueId === undefined && typeof semantic === 'string') request.semantic = semantic;
    else if (!is_count(uniqueId, 0xffffffff)) throw new PsplitError(`${request.name}: no unique id`, 'invalid-input');
    if (type !== undefined || kind === 'container') {
      if (kTypes.indexOf(type) < 1) throw new PsplitError(`${request.name}: unknown type ${type}`, 'invalid-input');
      request.type = type;
    }
    if (kind === 'container') {
      if (!is_count(componentCount, 16)) throw new PsplitError(`${request.name}: no component count`, 'invalid-input');
      request.componentCount = componentCount;
      request.normalized = normalized === true;
    }
    return request;
  });
}

export const make_job = (kind, data, { attributes } = {}) =>
  ({ kind, bytes: bytes_of(data), attributes: check_attributes(kind, attributes) });
