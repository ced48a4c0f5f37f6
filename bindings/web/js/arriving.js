// Bytes that arrive from the first to the last.
import { PsplitError } from './error.js';
import { on_abort } from './job.js';
import { is_node, node_module } from './node.js';

/** How long to wait for the end of a response all of whose bytes are there. */
export const kMostEndMs = 1000;

// A file of this machine, which fetch() of Node.js does not read.
async function* file_chunks(url) {
  const { createReadStream } = await node_module('node:fs');
  for await (const chunk of createReadStream(url)) yield new Uint8Array(chunk);
}
export function is_file(input) {
  return is_node && String(input?.url ?? input).startsWith('file:');
}

/** The response to a request, or a response that is given. Errors have its address. The signal ends the request; who reads the body ends that. */
export async function fetched(input, signal) {
  if (is_file(input)) return { url: String(input.url ?? input), body: file_chunks(new URL(input.url ?? input)) };
  const own = new AbortController(), release = on_abort(signal, () => own.abort());
  let response = input;
  try {
    if (signal?.aborted) own.abort();
    if (!(input instanceof Response)) response = await fetch(input, { signal: own.signal });
  } catch (error) {
    throw signal?.aborted ? new PsplitError('aborted', 'aborted') : new PsplitError(`${input?.url ?? input}: ${error.message}`, 'failed');
  }
  if (!response.ok || response.body === null) throw new PsplitError(`${response.url}: HTTP status ${response.status}`, 'failed');
  release();
  return response;
}

// How to read from a ReadableStream, over which not all browsers can iterate, or from an AsyncIterable.
function reader_of(source) {
  if (typeof source?.getReader === 'function') {
    const reader = source.getReader();
    return { next: () => reader.read(), cancel: () => reader.cancel() };
  }
  const iterator = source?.[Symbol.asyncIterator]?.();
  if (iterator === undefined) throw new PsplitError('the data is no stream', 'invalid-input');
  return { next: () => iterator.next(), cancel: async () => iterator.return?.() };
}

export class ArrivingBytes {
  #chunks = [];
  #length = 0;
  #expected = Infinity;
  #is_complete = false;
  #error;
  #changed = [];  // functions that wait for a change

  /**
   * @param {AsyncIterable<Uint8Array> | ReadableStream<Uint8Array>} source
   * @param {AbortSignal} [signal] ends it: what waits for bytes then rejects
   * @param {string} [url] of a response, for errors
   */
  constructor(source, signal, url) {
    this.url = url;
    this.#read(source, signal);
  }

  get length() {
    return this.#length;
  }
  get is_complete() {
    return this.#is_complete;
  }

  // No bytes are needed after these, unless some are asked for. When they are there, an abort does not end the source at once: its own
  // end follows, and a browser keeps only whole responses in its cache.
  expect(length) {
    if (Number.isSafeInteger(length) && length > 0) this.#expected = length;
  }
  #need(end) {
    if (end > this.#expected) this.#expected = end;
  }

  // Resolves when the first `count` bytes are there, or all.
  async until(count) {
    this.#need(count);
    while (this.#length < count && !this.#is_complete && this.#error === undefined) await this.#change();
    if (this.#error !== undefined && this.#length < count) throw this.#error;
  }

  // Views of bytes [begin, end), as they arrive; fewer if there are fewer.
  async* chunks(begin, end = Infinity) {
    this.#need(end);
    for (let i = 0, at = 0; at < end; ++i) {
      while (i === this.#chunks.length && !this.#is_complete && this.#error === undefined) await this.#change();
      if (i === this.#chunks.length && this.#error !== undefined) throw this.#error;
      if (i === this.#chunks.length) return;
      const bytes = this.#chunks[i], view = bytes.subarray(Math.max(0, begin - at), Math.max(0, Math.min(bytes.length, end - at)));
      at += bytes.length;
      if (view.length > 0) yield view;
    }
  }

  // A copy of these bytes, when they are there.
  async bytes(begin, end = Infinity) {
    await this.until(end);
    return this.copy(begin, end);
  }
  copy(begin, end = Infinity) {
    const copy = new Uint8Array(Math.max(0, Math.min(end, this.#length) - begin));
    let at = 0;
    for (const bytes of this.#chunks) {
      if (at < end && at + bytes.length > begin)
        copy.set(bytes.subarray(Math.max(0, begin - at), end - at), Math.max(0, at - begin));
      at += bytes.length;
    }
    return copy;
  }

  async #read(source, signal) {
    let reader, timer;
    const cancel = () => reader?.cancel().catch(() => {});
    const fail = (error) => {
      const message = error?.message ?? String(error), { url } = this;
      this.#error ??= error instanceof PsplitError ? error
        : new PsplitError(url === undefined ? message : `${url || 'the response'}: it ended early, after ${this.#length} bytes (${message})`, 'failed');
      if (this.#length < this.#expected) cancel();
      else timer ??= setTimeout(cancel, kMostEndMs);
      this.#wake();
    };
    const abort = () => fail(new PsplitError('aborted', 'aborted'));
    const let_go = on_abort(signal, abort);
    try {
      reader = reader_of(source);
      if (signal?.aborted) abort();
      while (this.#error === undefined && !this.#is_complete) {
        const { done, value } = await reader.next();
        if (this.#error !== undefined) {
          if (!done) cancel();
          break;
        }
        if (!done && !(value instanceof Uint8Array)) throw new PsplitError('a chunk is not a Uint8Array', 'invalid-input');
        this.#is_complete = done === true;
        if (!done) this.#chunks.push(value);
        this.#length += value?.length ?? 0;
        this.#wake();
      }
    } catch (error) {
      fail(error);
    }
    clearTimeout(timer);
    let_go();
  }
  #change() {
    return new Promise((resolve) => this.#changed.push(resolve));
  }
  #wake() {
    for (const resolve of this.#changed.splice(0)) resolve();
  }
}
