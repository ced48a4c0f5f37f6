// A job of a pool: what its workers are told, and what its caller is told.
import { PsplitError } from './error.js';
import { part_of } from './part.js';

// A container has a worker for this many of its bytes. Two workers are faster than one from about 150,000 bytes on, which
// are 40,000 faces with normals and texture coordinates, or 80,000 with positions alone: measured with
// bench/web/workers.mjs in Node.js on two processors.
const kBytesOfWorker = 75000;

// The number of streams that a container has, or claims to have.
const stream_count_of = (bytes) =>
  (bytes.length < 12 ? 1 : Math.max(1, new DataView(bytes.buffer, bytes.byteOffset).getUint32(8, true)));

export class Task {
  members = [];  // the pool's workers that have it
  module;        // what decodes it, when that is loaded
  #job;
  #byte_count;  // at first
  #workers;
  #transfer;
  #on_progress;
  #on_part;
  #done = new Map();
  #reported = 0;
  #is_final = new Set();  // delivered streams

  constructor(job, { transfer = false, onProgress, onPart, workers }) {
    if (workers !== undefined && !(Number.isInteger(workers) && workers > 0))
      throw new PsplitError('the option `workers` is not a positive integer', 'invalid-input');
    for (const [name, given] of Object.entries({ onProgress, onPart }))
      if (typeof (given ?? Object) !== 'function') throw new PsplitError(`the option \`${name}\` is not a function`, 'invalid-input');
    this.#job = job;
    this.#byte_count = job.bytes.length;
    this.#on_progress = onProgress ?? undefined;
    this.#on_part = onPart ?? undefined;
    this.#workers = workers;
    this.#transfer = transfer;
  }

  // The bytes if they arrive: ArrivingBytes.
  get source() {
    return this.#job.source;
  }
  // The number of workers to have.
  get most() {
    if (this.source?.is_complete && this.#job.chosen === undefined) this.#take_bytes(this.source);
    const { bytes, kind, source } = this.#job;
    if (kind === 'draco' || source !== undefined) return 1;
    return Math.min(this.#workers ?? Math.max(1, Math.floor(bytes.length / kBytesOfWorker)), stream_count_of(bytes));
  }
  // All bytes have arrived before a worker had time for them.
  #take_bytes(source) {
    this.#job = { ...this.#job, bytes: source.copy(0), source: undefined };
    this.#byte_count = this.#job.bytes.length;
    this.#transfer = true;
  }

  // For each worker its message, and the objects that are transferred with it. Each has a copy of the bytes, or all have a shared
  // one. The lead, which is the first, may take the bytes themselves: the others' messages are to be posted before. Bytes
  // that arrive are not in the message.
  messages(part_count, can_share) {
    const is_alone = part_count === 1, is_shared = can_share && !is_alone, { bytes, source, ...rest } = this.#job;
    if (bytes.length !== this.#byte_count) throw new PsplitError("the data's buffer was transferred elsewhere", 'invalid-input');
    const parts = this.#on_part !== undefined, reports = parts || this.#on_progress !== undefined;
    if (source !== undefined) return [[{ id: this.id, job: { ...rest, reports, parts, arrives: true } }, []]];
    const may_take = this.#transfer && bytes.length === bytes.buffer.byteLength && bytes.buffer instanceof ArrayBuffer;
    const shared = is_shared ? new Uint8Array(new SharedArrayBuffer(bytes.length)) : null;
    shared?.set(bytes);
    const channels = Array.from({ length: part_count - 1 }, () => new MessageChannel());
    return Array.from({ length: part_count }, (_, part) => {
      const ports = part === 0 ? channels.map(({ port1 }) => port1) : [channels[part - 1].port2];
      const own = shared ?? (part === 0 && may_take ? bytes : new Uint8Array(bytes));
      const job = { ...rest, bytes: own, reports, parts, ...(!is_alone && { part, part_count, ports, is_shared }) };
      return [{ id: this.id, job }, is_shared ? ports : [own.buffer, ...ports]];
    });
  }

  // Streams that a worker decoded since the job began.
  progress(member, done, total) {
    this.#done.set(member, done);
    this.#report([...this.#done.values()].reduce((a, b) => a + b, 0), total);
  }
  #report(done, total) {
    if (done > this.#reported) this.#on_progress?.((this.#reported = done), total);
  }

  deliver(part, counts) {
    for (let i = part.patches[0]; part.isFinal && i < part.patches[1]; ++i) this.#is_final.add(i);
    this.#on_part(part, counts);
  }

  // Delivers the streams that were not delivered on the way, or lacked faces.
  complete({ attributes, firstFaces, firstPoints, indices, ...counts }) {
    if (firstFaces === undefined) return;  // a Draco stream
    const total = firstFaces.length - 1, is_final = (i) => this.#is_final.has(i);
    for (let first = 0, end; this.#on_part !== undefined && first < total; first = end) {
      for (end = first + 1; end < total && is_final(end) === is_final(first);) ++end;
      if (is_final(first)) continue;
      const values = attributes.map(({ array, componentCount }) =>
        array.subarray(componentCount * firstPoints[first], componentCount * firstPoints[end]));
      const faces = indices.subarray(3 * firstFaces[first], 3 * firstFaces[end]);
      this.#on_part(part_of(attributes, firstFaces, firstPoints, first, end, [faces, ...values], true), counts);
    }
    this.#report(total, total);
  }
}
