// A container in an instance of the module, and the range of its streams that the instance decodes. Synchronous.
import { PsplitError } from './error.js';
import { head_of } from './head.js';
import { array_of, kSemantics, kTypes } from './types.js';

export const wrong_length = () => new PsplitError('container: its length is not the sum of its parts', 'invalid-input');

// glTF's component types.
const kComponentTypes = { int8: 5120, uint8: 5121, int16: 5122, uint16: 5123, uint32: 5125, float32: 5126 };

// The boxes of streams, from the optional section of a valid container's head. Undefined if the section is missing or its boxes
// are invalid.
function boxes_of(bytes, stream_count) {
  const kBoxes = 128, kBounds = 24, kSteps = 255;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), { begin, end } = head_of(bytes);
  for (let at = begin, length; at < end; at += length) {
    const type = bytes[at++];
    length = 0;
    for (let scale = 1; ; scale *= 128) {
      const byte = bytes[at++];
      length += (byte % 128) * scale;
      if (byte < 128) break;
    }
    if (type !== kBoxes) continue;
    if (length !== kBounds + 6 * stream_count) return undefined;
    const bounds = Array.from({ length: 6 }, (_, i) => view.getFloat32(at + 4 * i, true));
    return Float64Array.from({ length: 6 * stream_count }, (_, i) => {
      const low = bounds[i % 3], high = bounds[(i % 3) + 3], step = bytes[at + kBounds + i];
      return step === kSteps ? high : low + ((high - low) * step) / kSteps;
    });
  }
  return undefined;
}

// Columns of the directory.
export const kStreamBytes = 0;
export const kStitchBytes = 4;

export const sum = (numbers) => numbers.reduce((all, number) => all + number, 0);
export function joined(chunks) {
  const bytes = new Uint8Array(sum(chunks.map(({ length }) => length)));
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return bytes;
}

// How much of the container is present: at least the head, while the rest arrives (kFront); all of it (kWhole); or at least the
// head, without memory for the streams, for choose() (kOutline).
export const kFront = 0;
export const kWhole = 1;
export const kOutline = 2;

export class Container {
  #instance;
  #handle;
  #first;
  #end;
  #decoded;      // end of the decoded streams
  #memory;       // of the container's bytes
  #arrived = 0;  // bytes
  #rows;         // where the directory's rows are

  /**
   * @param {import('./instance.js').Instance} instance
   * @param {Uint8Array} bytes of the container
   * @param {number} [arrival] kFront, kWhole or kOutline
   */
  constructor(instance, bytes, arrival = kWhole) {
    this.#instance = instance;
    this.#handle = instance.open('open_container', bytes, arrival);
    this.#read_counts();
    this.boxes = boxes_of(bytes, this.stream_count);
  }

  #read_counts() {
    const instance = this.#instance, words = instance.view(Uint32Array, instance.exports.container_counts(this.#handle), 11);
    const [stream_count, has_residue, is_condensed, faces_at, points_at, memory, byte_count, has_borders, front_length, rows_at, row_length] = words;
    this.#memory = memory;
    this.byte_count = byte_count;
    this.#rows = { at: rows_at, length: row_length };
    this.front_length = front_length;
    this.has_borders = has_borders !== 0;
    this.stream_count = stream_count;
    this.has_residue = has_residue !== 0;
    this.is_condensed = is_condensed !== 0;
    // The first index of each stream, then the count of the mesh.
    this.first_faces = instance.view(Uint32Array, faces_at, stream_count + 1).slice();
    this.first_points = instance.view(Uint32Array, points_at, stream_count + 1).slice();
  }

  free() {
    if (!this.#instance.broken) this.#instance.exports.free_container(this.#handle);
  }

  get face_count() {
    return this.first_faces[this.stream_count];
  }
  get point_count() {
    return this.first_points[this.stream_count];
  }

  get patch_count() {
    return this.stream_count - (this.has_residue ? 1 : 0);
  }
  column(number) {
    const { at, length } = this.#rows, rows = this.#instance.view(Uint32Array, at, this.stream_count * length);
    return Uint32Array.from({ length: this.stream_count }, (_, i) => rows[i * length + number]);
  }

  // Turns an outline into the container of the given patches, which share no points. Returns the streams that they need, in the
  // order in which these must arrive after place_chosen(). The stitch map is needed only if has_borders.
  choose(patches, stitch_map) {
    const instance = this.#instance, boxes = this.boxes;
    if (this.has_borders && stitch_map.length !== sum(this.column(kStitchBytes))) throw wrong_length();
    const at = instance.copy_in(patches), stitch_at = this.has_borders ? instance.copy_in(stitch_map) : 0;
    const needed = this.#list('choose_patches', at, patches.length, stitch_at).slice();
    instance.exports.release(at);
    this.chosen = patches;
    this.boxes = boxes && Float64Array.from({ length: 6 * patches.length }, (_, i) => boxes[6 * patches[Math.floor(i / 6)] + (i % 6)]);
    return needed;
  }
  place_chosen() {
    if (!this.#instance.exports.place_chosen(this.#handle)) throw this.#instance.last_error();
    this.#read_counts();
  }

  // Appends the next bytes of an arriving container.
  add_bytes(bytes) {
    if (this.#arrived + bytes.length > this.byte_count) throw wrong_length();
    this.#instance.view(Uint8Array, this.#memory + this.#arrived, bytes.length).set(bytes);
    this.#arrived += bytes.length;
  }
  // Returns the number of streams that have arrived. They must be decoded before the next call.
  arrived_streams() {
    const stream_count = this.#instance.exports.arrive(this.#handle, this.#arrived);
    const failure = this.failure();
    if (failure !== undefined) throw failure.error;
    return stream_count;
  }
  // Ends arrival: all bytes must be present.
  end_arrival() {
    if (this.#arrived < this.byte_count) throw wrong_length();
  }

  // Requests the given attributes, or by default all of the first stream.
  request(attributes) {
    this.attributes = attributes ?? this.#stored();
    for (const { name, uniqueId, type, componentCount, normalized } of this.attributes) {
      const component_type = kComponentTypes[type];
      if (component_type === undefined)
        throw new PsplitError(`${name}: ${type} is not a type of glTF`, attributes === undefined ? 'unsupported' : 'invalid-input');
      const text = new TextEncoder().encode(name), at = this.#instance.copy_in(text);
      this.#instance.exports.request_attribute(this.#handle, at, text.length, uniqueId, component_type, componentCount,
        normalized ? 1 : 0);
      this.#instance.exports.release(at);
    }
  }
  #stored() {
    const words = this.#list('describe_container');
    return Array.from({ length: words.length / 5 }, (_, i) => {
      const [semantic, type, componentCount, normalized, uniqueId] = words.subarray(5 * i);
      return { name: kSemantics[semantic], uniqueId, type: kTypes[type], componentCount, normalized: normalized !== 0 };
    });
  }

  // Allocates the memory for streams [first, end).
  begin(first, end) {
    this.#first = this.#decoded = first;
    this.#end = end;
    if (!this.#instance.exports.begin_range(this.#handle, first, end)) throw this.#instance.last_error();
  }
  // Decodes the streams that have arrived, and calls on_streams(end) when the streams before `end` are decoded. Returns {
  // stage, error } if a stream failed.
  decode(on_streams) {
    for (let count; (count = this.#instance.exports.decode_streams(this.#handle)) > 0;)
      on_streams?.(this.#decoded += count);
    return this.failure();
  }
  failure() {
    const stage = this.#instance.exports.failed_stage(this.#handle);
    return stage === 0 ? undefined : { stage, error: this.#instance.last_error() };
  }

  // Views of the decoded streams [first, end) of the range: the indices, then the values of each attribute.
  arrays(first = this.#first, end = this.#end) {
    const view_of = (Type, at, numbers, width) => {
      const begin = numbers[first] - numbers[this.#first];
      return this.#instance.view(Type, at + begin * width * Type.BYTES_PER_ELEMENT, (numbers[end] - numbers[first]) * width);
    };
    const { range_faces, range_values } = this.#instance.exports;
    return [view_of(Uint32Array, range_faces(this.#handle), this.first_faces, 3),
      ...this.attributes.map(({ type, componentCount }, i) =>
        view_of(array_of(type), range_values(this.#handle, i), this.first_points, componentCount))];
  }
  // Offsets of the range's arrays in the mesh's arrays.
  get offsets() {
    return [3 * this.first_faces[this.#first],
      ...this.attributes.map(({ componentCount }) => componentCount * this.first_points[this.#first])];
  }
  // Whether the faces of each stream are final.
  get resolved_streams() {
    return this.#instance.view(Uint8Array, this.#instance.exports.resolved_streams(this.#handle), this.stream_count);
  }

  // The range's stitching data, for the lead worker.
  stitching() {
    return this.#list('stitching').slice();
  }
  add_stitching(first, words) {
    const at = this.#instance.copy_in(words);
    this.#instance.exports.add_stitching(this.#handle, first, at, words.length);
    this.#instance.exports.release(at);
  }
  // Resolves the references of all streams that are not final. Returns pairs: a corner of the mesh, and its index.
  resolve_rest() {
    return this.#list('resolve_rest');
  }

  #list(name, ...options) {
    const words = this.#instance.exports[name](this.#handle, ...options);
    if (words === 0) throw this.#instance.last_error();
    const [at, length] = this.#instance.view(Uint32Array, words, 2);
    return this.#instance.view(Uint32Array, at, length);
  }
}
