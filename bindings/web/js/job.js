// The arguments of the public functions, checked, as the job that a decoder runs.
import { PsplitError } from './error.js';
import { kTypes } from './types.js';

export const invalid = (message) => new PsplitError(message, 'invalid-input');

export function bytes_of(data) {
  const is_shared = typeof SharedArrayBuffer !== 'undefined' && data instanceof SharedArrayBuffer;
  if (!ArrayBuffer.isView(data) && !(data instanceof ArrayBuffer) && !is_shared)
    throw invalid('the data is not an ArrayBuffer or a view of one');
  try {
    return data instanceof Uint8Array && data.length > 0 ? data : new Uint8Array(data.buffer ?? data, data.byteOffset, data.byteLength);
  } catch {
    throw invalid("the data's buffer was transferred elsewhere");
  }
}

export function check_signal(signal) {
  if (signal != null && typeof signal.addEventListener !== 'function') throw invalid('the option `signal` is not an AbortSignal');
}

// Functions by signal. A signal has one listener: Node.js warns of more than ten.
const aborting = new WeakMap();

/** Calls abort() when the signal aborts, but not if it has aborted. Returns a function that lets go of the signal. */
export function on_abort(signal, abort) {
  if (signal == null) return () => {};
  let all = aborting.get(signal);
  if (all === undefined) {
    all = { waiting: new Set(), listener: () => { for (const each of [...all.waiting]) each(); } };
    aborting.set(signal, all);
  }
  if (all.waiting.size === 0) signal.addEventListener('abort', all.listener);
  all.waiting.add(abort);
  return () => {
    if (all.waiting.delete(abort) && all.waiting.size === 0) signal.removeEventListener('abort', all.listener);
  };
}

/** Settles as the promise, or rejects when the signal aborts. */
export const or_abort = (promise, signal) => new Promise((resolve, reject) => {
  const abort = () => reject(new PsplitError('aborted', 'aborted'));
  if (signal?.aborted) abort();
  Promise.resolve(promise).then(resolve, reject).finally(on_abort(signal, abort));
});

/** A signal that aborts with others (null and undefined are left out) and when end() is called, which lets go of them. */
export function signal_of(...others) {
  const controller = new AbortController(), { signal } = controller, abort = () => controller.abort();
  const signals = others.filter((other) => other != null);
  signals.forEach(check_signal);
  const let_go = signals.map((other) => on_abort(other, abort));
  if (signals.some(({ aborted }) => aborted)) abort();
  return { signal, end() {
    for (const each of let_go) each();
    abort();
  } };
}

function check_attributes(kind, attributes) {
  if (attributes == null) return undefined;
  if (!Array.isArray(attributes)) throw invalid('the option `attributes` is not an array');
  return attributes.map((attribute) => {
    if (attribute === null || typeof attribute !== 'object') throw invalid('an element of the option `attributes` is not an object');
    const { name, uniqueId, semantic, type, componentCount, normalized } = attribute, text = name ?? semantic ?? `attribute ${uniqueId}`;
    if (typeof text !== 'string') throw invalid('the name of an attribute is not a string');
    const request = { uniqueId, name: text };
    const is_count = (value, most) => Number.isInteger(value) && value >= 0 && value <= most;
    if (kind === 'draco' && uniqueId === undefined && typeof semantic === 'string') request.semantic = semantic;
    else if (!is_count(uniqueId, 0xffffffff)) throw invalid(`${request.name}: no unique id`);
    if (type !== undefined || kind === 'container') {
      if (kTypes.indexOf(type) < 1) throw invalid(`${request.name}: unknown type ${String(type)}`);
      request.type = type;
    }
    if (kind === 'container') {
      if (!is_count(componentCount, 16)) throw invalid(`${request.name}: no component count`);
      request.componentCount = componentCount;
      request.normalized = normalized === true;
    }
    return request;
  });
}

// `options` may be null or undefined.
export const make_job = (kind, data, options) =>
  ({ kind, bytes: bytes_of(data), attributes: check_attributes(kind, options?.attributes) });
