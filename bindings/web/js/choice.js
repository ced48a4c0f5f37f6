// Patches that a caller chooses, and the bytes of a file that they need. Pages load this when they choose patches.
import { ArrivingBytes, fetched, is_file, kMostEndMs } from './arriving.js';
import { joined, kStitchBytes, kStreamBytes, sum, wrong_length } from './container.js';
import { counts_of } from './container_job.js';
import { PsplitError } from './error.js';
import { front_bytes } from './head.js';
import { decoder_of } from './instance.js';
import { on_abort, or_abort } from './job.js';
import { with_arrays } from './part.js';
import { array_of } from './types.js';

// The first bytes of a file are asked for together: they often have its JSON and the head of its first container.
const kFirstBytes = 16384;
// Of a container, before the length of its head is known.
const kFrontBytes = 4096;
// Ranges that are nearer to each other than this are one request, up to a size.
const kNearBytes = 8192, kMostBytes = 262144, kMostGroups = 64;
const kMostRequests = 6;  // at a time

const failed = (message) => new PsplitError(message, 'failed');
const invalid = (message) => new PsplitError(message, 'invalid-input');

// What a range of a file can be compared by, for HTTP's If-Range: a strong tag, or else a date that is older than the response.
function validator_of({ headers }) {
  const tag = headers.get('ETag'), date = headers.get('Last-Modified');
  if (tag?.startsWith('"')) return { name: 'ETag', value: tag };
  const is_strong = Date.parse(headers.get('Date')) - Date.parse(date) >= 1000;
  return is_strong ? { name: 'Last-Modified', value: date } : null;
}

// [begin, end, length of the file] of a response with a part of it; null if it does not say so.
function range_of({ headers }) {
  const numbers = /^bytes (\d{1,15})-(\d{1,15})\/(\d{1,15})$/.exec(headers.get('Content-Range'));
  return numbers && [Number(numbers[1]), Number(numbers[2]) + 1, Number(numbers[3])];
}

// What read() gives after the last byte that was asked for. If the server does not end its response soon, that is its end.
async function end_of(reader) {
  let timer;
  const late = new Promise((resolve) => (timer = setTimeout(resolve, kMostEndMs, { done: true })));
  return Promise.race([reader.read(), late]).finally(() => clearTimeout(timer));
}

// A file on a server that sends parts of it. Only bytes that are needed are asked for.
class RangedFile {
  #fetch;       // (range, headers) => Promise<{ response, release }>, where release() lets no signal abort the request any more
  url;
  #signal;
  #validator;
  #is_foreign;  // its server may not know If-Range, so that browsers do not send it
  #pieces;      // { begin, end, bytes }, which were asked for
  #running = 0;
  #waiting = [];

  constructor(fetch_range, { response, release }, [, end, total], validator, signal) {
    this.#fetch = fetch_range;
    this.url = response.url;
    this.#signal = signal;
    this.#validator = validator;
    const { location } = globalThis;
    this.#is_foreign = location !== undefined && new URL(response.url, location.href).origin !== location.origin;
    this.total = total;
    this.#pieces = [{ begin: 0, end, bytes: new ArrivingBytes(this.#body(response, release, 0, end), signal) }];
  }

  // As ArrivingBytes. If it is not there, it is asked for.
  async* chunks(begin, end = Infinity) {
    begin = Math.max(0, begin);
    end = Math.min(end, this.total);
    this.ask([[begin, end]]);
    for (let at = begin; at < end;) {
      const piece = this.#pieces.find((of) => of.begin <= at && at < of.end);
      for await (const chunk of piece.bytes.chunks(at - piece.begin, Math.min(end, piece.end) - piece.begin)) {
        at += chunk.length;
        yield chunk;
      }
    }
  }
  async bytes(begin, end) {
    const chunks = [];
    for await (const chunk of this.chunks(begin, end)) chunks.push(chunk);
    return joined(chunks);
  }

  // Asks for the bytes of ranges [begin, end) that were not asked for yet, the first range first.
  ask(ranges) {
    const requests = [];
    for (const range of ranges)
      for (const [begin, end] of this.#missing(range)) {
        const near = requests.slice(-kMostGroups).find((of) => begin - of.end < kNearBytes && of.begin - end < kNearBytes &&
          Math.max(end, of.end) - Math.min(begin, of.begin) <= kMostBytes);
        if (near === undefined) requests.push({ begin, end });
        else Object.assign(near, { begin: Math.min(begin, near.begin), end: Math.max(end, near.end) });
      }
    for (const { begin, end } of requests)
      this.#pieces.push({ begin, end, bytes: new ArrivingBytes(this.#requested(begin, end), this.#signal) });
  }
  #missing([begin, end]) {
    let parts = begin < end ? [[begin, end]] : [];
    for (const piece of this.#pieces)
      parts = parts.flatMap(([from, to]) => (piece.end <= from || to <= piece.begin ? [[from, to]]
        : [[from, piece.begin], [piece.end, to]].filter(([first, last]) => first < last)));
    return parts;
  }

  async* #requested(begin, end) {
    if (this.#running === kMostRequests) await new Promise((resolve) => this.#waiting.push(resolve));
    else ++this.#running;
    try {
      const { name, value } = this.#validator;
      const { response, release } = await this.#fetch(`bytes=${begin}-${end - 1}`, this.#is_foreign ? {} : { 'If-Range': value });
      const other = response.headers.get(name), range = range_of(response);
      const may_lack = response.status === 206 && !this.#is_foreign && name !== 'ETag';
      if (response.status === 416 || (response.ok && other !== value && !(may_lack && other === null)))
        throw failed(`${this.url}: the file changed while it was read`);
      if (response.status !== 200 && response.status !== 206) throw failed(`${this.url}: HTTP status ${response.status}`);
      if (response.status === 206 && (range === null || range[0] !== begin || range[1] !== end || range[2] !== this.total))
        throw failed(`${this.url}: the server sent other bytes than it was asked for`);
      yield* this.#body(response, release, begin, end);
    } catch (error) {
      throw error instanceof PsplitError || error?.name === 'AbortError' ? error : failed(`${this.url}: ${error.message}`);
    } finally {
      const next = this.#waiting.shift();
      if (next === undefined) --this.#running;
      else next();
    }
  }
  // Bytes [begin, end) of the file: all of a response, or a part of one that has the whole file.
  async* #body({ body, status }, release, begin, end) {
    const is_whole = status === 200, reader = body.getReader();
    let at = is_whole ? 0 : begin;
    try {
      // A response is read to its end, so that its connection can be used again.
      while (at < end || !is_whole) {
        const { done, value } = await (at < end ? reader.read() : end_of(reader));
        if (done && at < end) throw failed(`${this.url}: the server sent fewer bytes than it said`);
        if (done) return;
        if (at + value.length > end && !is_whole) throw failed(`${this.url}: the server sent more bytes than it said`);
        const part = value.subarray(Math.max(0, begin - at), Math.min(value.length, end - at));
        at += value.length;
        if (at === end && !is_whole) release();
        if (part.length > 0) yield part;
      }
    } finally {
      reader.cancel().catch(() => {});
    }
  }
}

/**
 * Opens a file for ArrivingAsset: by ranges if its server sends them and tells files apart, otherwise from the first byte to the
 * last.
 */
export async function open_ranged(input, signal) {
  const is_request = input instanceof Request;
  const fetch_range = async (range, more = {}) => {
    const headers = new Headers(is_request ? input.headers : undefined);
    for (const [name, value] of Object.entries({ Range: range, ...more })) headers.set(name, value);
    const own = new AbortController(), abort = () => own.abort(), release = on_abort(signal, abort);
    if (signal.aborted) abort();
    return { response: await fetch(is_request ? input.clone() : input, { headers, signal: own.signal }), release };
  };
  let response = input, first = null;
  if (!(input instanceof Response) && !is_file(input) && !(is_request && (input.method !== 'GET' || input.headers.has('Range')))) {
    first = await fetch_range(`bytes=0-${kFirstBytes - 1}`).catch(() => null);
    response = first && first.response;
    const range = response && range_of(response), validator = response && validator_of(response);
    const is_range = response?.status === 206 && range !== null && validator !== null && !response.headers.has('Content-Encoding') &&
      range[0] === 0 && range[1] === Math.min(kFirstBytes, range[2]);
    if (is_range) return { file: new RangedFile(fetch_range, first, range, validator, signal), url: response.url };
    if (response === null || response.status === 206 || response.status === 416) {
      response?.body?.cancel().catch(() => {});
      response = input;
    }
  }
  const { url, body } = await fetched(response, signal);
  first?.release();
  return { file: new ArrivingBytes(body, signal, url), url };
}

function checked(given, patch_count) {
  if (typeof given[Symbol.iterator] !== 'function') throw invalid('`choose` returned no list of patches');
  const chosen = [...given], seen = new Set();
  for (const patch of chosen) {
    if (!(Number.isInteger(patch) && patch >= 0 && patch < patch_count)) throw invalid(`\`choose\` returned ${String(patch)}, which is no patch`);
    if (seen.size === seen.add(patch).size) throw invalid(`\`choose\` returned patch ${patch} twice`);
  }
  return Uint32Array.from(chosen);
}

// The mesh of no patches.
export const empty_mesh = (attributes) => ({ faceCount: 0, pointCount: 0, patchCount: 0, hasResidue: false, isCondensed: false,
  firstFaces: new Uint32Array(1), firstPoints: new Uint32Array(1), indices: new Uint32Array(),
  attributes: with_arrays(attributes, attributes.map(({ type }) => new (array_of(type))())), chosen: new Uint32Array() });

/**
 * Asks choose() about a container, and asks for the bytes that the chosen patches need. Resolves to null if the whole container is
 * wanted; otherwise to { chosen, parts }, the numbers of the patches and what a job with `chosen` gets, as it arrives.
 * @param {(front: Uint8Array) => Promise<WebAssembly.Module>} module_for what decodes a container
 * @param {{ file: RangedFile | ArrivingBytes, begin: number, end: number }} place of the container
 * @param {(counts: ContainerCounts) => object} check returns what choose() is told besides; throws if the container does not fit
 */
export async function planned(module_for, { file, begin, end }, choose, check, signal) {
  const read = (from, to) => file.bytes(Math.min(end, begin + from), Math.min(end, begin + to));
  let front = await read(0, kFrontBytes);
  const front_length = front_bytes(front);
  if (front.length < front_length) front = joined([front, await read(front.length, front_length)]);
  const decoder = decoder_of(await module_for(front));
  const { counts, has_borders, stream_bytes, face_counts, stitch_at, streams_at } = decoder.with_outline(front, (container) => {
    const bytes = container.column(kStreamBytes), length = container.front_length + sum(container.column(kStitchBytes));
    if (end !== Infinity && begin + length + sum(bytes) !== end) throw wrong_length();
    return { counts: counts_of(container), has_borders: container.has_borders, stream_bytes: bytes,
      face_counts: Uint32Array.from({ length: container.patch_count }, (_, i) => container.first_faces[i + 1] - container.first_faces[i]),
      stitch_at: container.front_length, streams_at: length };
  });
  const { patchCount, boxes } = counts;
  const given = await or_abort(choose({ ...check(counts), patchCount, byteLengths: stream_bytes.slice(0, patchCount), faceCounts: face_counts,
    ...(boxes && { boxes: boxes.slice(0, 6 * patchCount) }) }), signal);
  if (given === undefined || given === null) return null;
  const chosen = checked(given, patchCount), stitch_map = has_borders && chosen.length > 0 ? await read(stitch_at, streams_at) : null;
  const needed = stitch_map === null ? chosen : decoder.with_outline(front, (container) => container.choose(chosen, stitch_map));
  const starts = new Float64Array(stream_bytes.length + 1);
  stream_bytes.forEach((bytes, i) => (starts[i + 1] = starts[i] + bytes));
  const range = (stream) => [streams_at + starts[stream], streams_at + starts[stream + 1]];
  file.ask?.([...needed].map((stream) => range(stream).map((at) => begin + at)));
  async function* parts() {
    yield front;
    if (stitch_map !== null) yield stitch_map;
    for (const stream of needed) yield await read(...range(stream));
  }
  return { chosen, parts: parts() };
}
