// Decoding a container: by one instance of the module, or by several workers that share its streams.
//
// A job has `bytes` and `attributes`. With `reports`, the worker posts { done, total } of streams on the way; with
// `parts`, also { part, counts } for the streams themselves, with the counts of the mesh.
//
// A job of several workers has `part_count`, `is_shared`, and `part` and `ports` of each. Part 0 is the lead, which has
// a port for each helper; helpers have one. All decode a range of streams each. Then each helper sends one message to
// the lead, which resolves the references from one range to another, and has the result. Arrays of the mesh are
// assembled by the lead, or if `is_shared`, all write to shared ones, which the lead sends to the helpers at first.
//
// A job that `arrives` has no bytes: they come in chunks, to one worker. If it has `chosen`, the numbers of patches, the first
// chunk has the bytes to the end of the head; the next one has the stitch map if patches share values at borders; and all others
// the streams that Container.choose names.
import { Container, joined, kFront, kOutline } from './container.js';
import { error_from_data, error_to_data } from './error.js';
import { front_bytes } from './head.js';
import { part_of, with_arrays } from './part.js';
import { array_of } from './types.js';

// The time for assembling a mesh, as a part of the time for decoding it on one worker.
const kAssembling = 0.045;
const kReportMs = 16;
// Chosen streams that are decoded at once, if they are there.
const kTogether = 12;

// Stages at which a job fails. A failure of an earlier stage comes before others, and then that of the lowest stream:
// so the error is the one that one worker has. Faults of a worker itself come last.
const kBegin = 0, kReferences = 2, kWorker = 3;

// The streams of a part: [first, end). Parts have about the same number of faces, except that the lead, which assembles
// the mesh, has less.
function range_of({ first_faces, stream_count, face_count }, { part, part_count, is_shared }) {
  const assembling = is_shared ? 0 : kAssembling;
  const bound = (i) => {
    if (i === 0 || i === part_count) return i === 0 ? 0 : stream_count;
    const faces = face_count * Math.max(0, (i * (1 + assembling)) / part_count - assembling);
    const at = first_faces.findIndex((first) => first >= faces);
    return faces - first_faces[at - 1] < first_faces[at] - faces ? at - 1 : at;
  };
  return [bound(part), bound(part + 1)];
}

function opened(instance, { bytes, attributes }) {
  const container = new Container(instance, bytes);
  container.request(attributes);
  return container;
}

// Streams [first, end), which are decoded, in parts that are final or not. Corners that refer to another range have no
// point yet: their faces are degenerate until the lead knows the points.
function* decoded_parts(container, first, end) {
  const { attributes, first_faces, first_points, point_count } = container;
  const resolved = container.resolved_streams.slice(first, end);
  for (let begin = first, at; begin < end; begin = at) {
    for (at = begin + 1; at < end && resolved[at - first] === resolved[begin - first];) ++at;
    const arrays = container.arrays(begin, at).map((view) => view.slice()), [indices] = arrays;
    const is_final = resolved[begin - first] !== 0;
    for (let i = 0; !is_final && i < indices.length; i += 3)
      if (Math.max(indices[i], indices[i + 1], indices[i + 2]) >= point_count) indices.fill(0, i, i + 3);
    yield part_of(attributes, first_faces, first_points, begin, at, arrays, is_final);
  }
}

// The function that decoding calls with the end of the decoded streams. It `must` report at their end, and before it waits.
function reporter(container, first, end, { reports, parts }, post) {
  if (!reports) return undefined;
  let last = -Infinity, reported = first;
  return (at, must = at === end) => {
    const now = performance.now();
    if (at === reported || (now - last < kReportMs && !must)) return;
    last = now;
    if (parts) for (const part of decoded_parts(container, reported, at)) post({ part, counts: counts_of(container) });
    reported = at;
    post({ done: at - first, total: container.stream_count });
  };
}

export const counts_of = ({ boxes, chosen, face_count, has_residue, is_condensed, patch_count, point_count }) => ({ faceCount: face_count,
  pointCount: point_count, patchCount: patch_count, hasResidue: has_residue, isCondensed: is_condensed,
  ...(boxes && { boxes }), ...(chosen && { chosen }) });
const result_of = (container, [indices, ...values]) => ({ ...counts_of(container), firstFaces: container.first_faces,
  firstPoints: container.first_points, indices, attributes: with_arrays(container.attributes, values) });

export function decode_alone(instance, job, post) {
  const container = opened(instance, job);
  try {
    container.begin(0, container.stream_count);
    const failure = container.decode(reporter(container, 0, container.stream_count, job, post));
    if (failure !== undefined) throw failure.error;
    return result_of(container, container.arrays().map((view) => view.slice()));
  } finally {
    container.free();
  }
}

// The streams are decoded when they have arrived: inbox.next() resolves to the next bytes, or null at their end.
export async function decode_arriving(instance, job, post, inbox) {
  let front = new Uint8Array(0), count = 0, end = 0, report;
  const { chosen } = job;
  while (front.length < front_bytes(front)) {
    const chunk = await inbox.next();
    if (chunk === null) return instance.guarded(() => decode_alone(instance, { ...job, bytes: front }, post));
    front = joined([front, chunk]);
  }
  const container = instance.guarded(() => new Container(instance, front, chosen === undefined ? kFront : kOutline));
  try {
    if (chosen !== undefined) {
      const stitch_map = container.has_borders ? await inbox.next() : null;
      instance.guarded(() => container.choose(chosen, stitch_map));
      instance.guarded(() => container.place_chosen());
    }
    const { stream_count } = container;
    for (let chunk = chosen === undefined ? front : await inbox.next(); chunk !== null; chunk = await inbox.next())
      instance.guarded(() => {
        container.add_bytes(chunk);
        // Some chosen streams together are faster than one by one.
        if (chosen !== undefined && ++count % kTogether > 0 && inbox.has_more) return;
        if (container.arrived_streams() === 0) return;
        if (report === undefined) {
          container.request(job.attributes);
          container.begin(0, stream_count);
          const post_report = reporter(container, 0, stream_count, job, post) ?? (() => {});
          report = (at, must) => post_report((end = at), must);
        }
        const failure = container.decode(report);
        if (failure !== undefined) throw failure.error;
        report(end, true);
      });
    return instance.guarded(() => {
      container.end_arrival();
      return result_of(container, container.arrays().map((view) => view.slice()));
    });
  } finally {
    container.free();
  }
}

// Calls use(), and returns a failure if it has one or throws.
function attempt(instance, stage, use) {
  try {
    return instance.guarded(use);
  } catch (error) {
    return { stage: instance.broken ? kWorker : stage, error };
  }
}

const next_message = (port) => new Promise((resolve, reject) => {
  port.onmessage = ({ data }) => resolve(data);
  port.onmessageerror = () => reject(new Error('a message between workers cannot be read'));
});

const is_before = (a, b) => b === undefined || a.stage < b.stage || (a.stage === b.stage && a.error.patch < b.error.patch);
const first_failure = (failures) =>
  failures.reduce((first, failure) => (failure !== undefined && is_before(failure, first) ? failure : first), undefined);

// New arrays of the mesh, in buffers of a type.
function new_arrays({ attributes, face_count, point_count }, Buffer) {
  const array = (Type, length) => new Type(new Buffer(length * Type.BYTES_PER_ELEMENT));
  return [array(Uint32Array, 3 * face_count),
    ...attributes.map(({ type, componentCount }) => array(array_of(type), point_count * componentCount))];
}
function write_arrays(arrays, from, offsets) {
  for (const [i, array] of arrays.entries()) array.set(from[i], offsets[i]);
}

export async function decode_as_lead(instance, job, post) {
  const messages = job.ports.map(next_message);
  let container, arrays = null;
  const begun = attempt(instance, kBegin, () => {
    container = opened(instance, job);
    const [first, end] = range_of(container, job);
    container.begin(first, end);
    if (job.is_shared) arrays = new_arrays(container, SharedArrayBuffer);
  });
  if (job.is_shared) for (const port of job.ports) port.postMessage(arrays);
  const decoded = begun ?? attempt(instance, kBegin, () => {
    const failure = container.decode(reporter(container, ...range_of(container, job), job, post));
    arrays ??= new_arrays(container, ArrayBuffer);
    write_arrays(arrays, container.arrays(), container.offsets);
    return failure;
  });
  try {
    return finished(instance, container, arrays, decoded, await Promise.all(messages));
  } finally {
    for (const port of job.ports) port.close();
    container?.free();
  }
}

// The result of a lead that has all messages of its helpers.
function finished(instance, container, arrays, decoded, messages) {
  let failure = first_failure([decoded, ...messages.map(failure_of)]);
  if (failure === undefined || failure.stage === kReferences) {
    const resolved = attempt(instance, kReferences, () => {
      for (const { first, stitching } of messages) container.add_stitching(first, stitching);
      for (const { slices, offsets } of messages) if (slices) write_arrays(arrays, slices, offsets);
      const corrections = container.resolve_rest(), [indices] = arrays;
      for (let i = 0; i < corrections.length; i += 2) indices[corrections[i]] = corrections[i + 1];
    });
    failure = first_failure([failure, resolved]);
  }
  if (failure !== undefined) throw failure.error;
  return result_of(container, arrays);
}

// An error loses its class on the way from one worker to another.
const failure_of = ({ failure }) => failure && { stage: failure.stage, error: error_from_data(failure.error) };

export async function decode_as_helper(instance, job, post) {
  const [port] = job.ports;
  const shared_arrays = job.is_shared ? next_message(port) : null;
  let container, message = {};
  let failure = attempt(instance, kBegin, () => {
    container = opened(instance, job);
    const [first, end] = range_of(container, job);
    container.begin(first, end);
    const failed = container.decode(reporter(container, first, end, job, post));
    if (failed === undefined || failed.stage === kReferences) {
      const slices = job.is_shared ? null : container.arrays().map((view) => view.slice());
      message = { first, offsets: container.offsets, stitching: container.stitching(), slices };
    }
    return failed;
  });
  const arrays = await shared_arrays;
  if (arrays !== null && failure === undefined)
    failure = attempt(instance, kWorker, () => write_arrays(arrays, container.arrays(), container.offsets));
  if (failure !== undefined) message.failure = { stage: failure.stage, error: error_to_data(failure.error) };
  container?.free();
  port.postMessage(message, [message.stitching, ...(message.slices ?? [])].filter(Boolean).map(({ buffer }) => buffer));
}
