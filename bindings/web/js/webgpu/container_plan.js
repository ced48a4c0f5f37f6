// What JavaScript reads of a container: the directory, the stitch map and the heads of its streams. The rest is decoded on the
// device. A container that the device does not decode is refused.
import { kSemantics, kTypes } from '../types.js';
import { are_justified, read_directory } from './directory.js';
import { kBoundsWords, kGridWords, kNone, kStateWords, record_words, stream_words } from './layout.js';
import { refuse } from './refusal.js';
import { read_stitch_map } from './stitch_map.js';
import { kCodingInteger, kCodingQuantized, read_stream_head } from './stream_head.js';

// One thread takes the steps of a stream. Displays' watchdogs end what takes seconds.
const kMostFacesOfAStream = 65536;
const kMostGridComponents = kGridWords - 2;
const kNoOutput = { out: kNone, out_bytes: 0, stride: 0, is_grid: 0, grid: 0, bounds: kNone };

// The attributes that the first stream stores, as decodeContainer names them.
const stored = ({ attributes }) => attributes.map(({ semantic, type, components, normalized, unique_id }) =>
  ({ name: kSemantics[semantic], uniqueId: unique_id, type: kTypes[type], componentCount: components, normalized }));

// How values of a request are written: bytes of a component, and whether places on the grid stand for values.
function output_of({ coding, type, type_bytes, components }, request, as) {
  if (kTypes[type] !== request.type || components !== request.componentCount) refuse('values that are to be converted');
  if (coding === kCodingQuantized && components > kMostGridComponents) refuse('quantized values of many components');
  const is_grid = as === 'quantized' && coding === kCodingQuantized;
  if (!is_grid && (type_bytes > 4 || (coding === kCodingInteger && kTypes[type] === 'bool'))) refuse('values of 64 bits');
  return { is_grid, out_bytes: is_grid ? 2 : type_bytes };
}

export class ContainerPlan {
  #bytes;
  #stitch = [];
  #heads = [];
  #words = [];  // of memory, by stream
  #sizes = null;

  /**
   * @param {Uint8Array} bytes
   * @param {object[] | undefined} attributes those that are wanted; by default all of the first stream
   * @param {'float32' | 'quantized'} as how quantized values are written
   * @param {number} most_words of memory for a stream
   */
  constructor(bytes, attributes, as, most_words) {
    const directory = (this.directory = read_directory(bytes));
    this.#bytes = bytes;
    if (directory.has_residue) refuse('a residue');
    for (let i = 0; i < directory.stream_count; ++i) this.#read_stream(i, most_words);
    this.attributes = attributes ?? stored(this.#heads[0]);
    // The first stream says how values are written; others must say the same.
    this.outputs = this.attributes.map((request) => {
      const found = this.#heads.map(({ attributes: all }) => all.find(({ unique_id }) => unique_id === request.uniqueId) ?? refuse('an attribute that is missing'));
      const outputs = found.map((attribute) => output_of(attribute, request, as)), { is_grid, out_bytes } = outputs[0];
      if (outputs.some((other) => other.is_grid !== is_grid) || (is_grid && found.some(({ coding }) => coding !== kCodingQuantized)))
        refuse('streams with other codings than the first');
      const is_bounded = found.every(({ semantic, coding, components }) => semantic === 0 && coding === kCodingQuantized && components === 3);
      return { request, is_grid, out_bytes, is_bounded, coding: found[0].coding, stride: Math.ceil((out_bytes * request.componentCount) / 4) };
    });
    if (new Set(this.attributes.map(({ uniqueId }) => uniqueId)).size < this.attributes.length) refuse('an attribute that is wanted twice');
    const point_bytes = this.outputs.reduce((sum, { request, out_bytes }) => sum + out_bytes * request.componentCount, 0);
    if (!are_justified(12 * this.face_count + point_bytes * this.point_count, bytes.length)) refuse('results that the bytes do not justify');
  }

  get stream_count() {
    return this.directory.stream_count;
  }
  get face_count() {
    return this.directory.first_faces[this.stream_count];
  }
  get point_count() {
    return this.directory.first_points[this.stream_count];
  }
  get byte_count() {
    return this.#bytes.length;
  }
  /** The words of results. */
  get result_words() {
    return 3 * this.face_count + this.outputs.reduce((sum, { stride }) => sum + stride * this.point_count, 0);
  }

  /** The words that the container takes of a batch: of plan, streams, attributes, walks, results and states. */
  get sizes() {
    return (this.#sizes ??= this.#count_sizes());
  }
  #count_sizes() {
    const sizes = [0, 0, 0, 0, this.result_words, kStateWords * this.stream_count];
    this.#heads.forEach((head, i) => record_words(head, this.#row(i), this.#stitch[i]).forEach((words, k) => (sizes[k] += words)));
    for (const { coding, is_bounded } of this.outputs)
      sizes[5] += (coding === kCodingQuantized ? kGridWords * this.stream_count : 0) + (is_bounded ? kBoundsWords : 0);
    return sizes;
  }

  #row(i) {
    const { faces, points, references, stream_at } = this.directory;
    return { face_count: faces[i], point_count: points[i], reference_count: references[i], stream_bytes: stream_at[i + 1] - stream_at[i] };
  }
  #read_stream(i, most_words) {
    const { stitch_at, stream_at } = this.directory, row = this.#row(i), runs = [], pairs = [];
    if (row.face_count > kMostFacesOfAStream) refuse('a stream of many faces');
    const head = read_stream_head(this.#bytes, stream_at[i], stream_at[i + 1], row.face_count, this.#heads.at(-1));
    const words = stream_words(head, row);
    if (words > most_words) refuse('a stream that takes much memory');
    const repeat_count = read_stitch_map(this.#bytes, stitch_at[i], stitch_at[i + 1], i, row.point_count, row.reference_count, runs, pairs);
    this.#heads.push(head);
    this.#words.push(words);
    this.#stitch.push({ runs, pairs, repeat_count });
  }

  /**
   * Adds the streams to a batch.
   * @param {import('./layout.js').Layout} layout
   * @param {number} bytes_at the place of the container in the batch's bytes
   */
  place(layout, bytes_at) {
    const { directory } = this, { stream_at, first_faces, first_points } = directory;
    const first_stream = (this.first_stream = layout.streams_added);
    this.indices = layout.take_results(3 * this.face_count);
    for (const output of this.outputs) {
      output.out = layout.take_results(output.stride * this.point_count);
      if (output.coding === kCodingQuantized) output.grids = layout.take_states(kGridWords * this.stream_count);
      if (output.is_bounded) output.bounds = layout.take_states(kBoundsWords);
    }
    const has_walk = directory.references.some((count) => count > 0) ? 1 : 0, mesh_points = this.point_count, { indices } = this;
    const output_of_attribute = (attribute, all) => {
      const k = this.attributes.findIndex(({ uniqueId }) => uniqueId === attribute.unique_id), output = this.outputs[k];
      // Of several attributes with this id, the first one is meant.
      if (k < 0 || all.find(({ unique_id }) => unique_id === attribute.unique_id) !== attribute) return kNoOutput;
      return { out: output.out, out_bytes: output.out_bytes, stride: output.stride, is_grid: output.is_grid ? 1 : 0,
        grid: output.grids ?? 0, bounds: output.bounds ?? kNone };
    };
    // Streams mostly have one list of attributes.
    let list, outputs;
    for (let i = 0; i < this.stream_count; ++i) {
      const place_of_stream = { bytes_at, end: stream_at[i + 1] + bytes_at, first_face: first_faces[i], first_point: first_points[i], mesh_points,
        has_walk, first_stream, indices, grid_offset: kGridWords * i, words: this.#words[i] };
      const head = this.#heads[i];
      if (head.attributes !== list) {
        list = head.attributes;
        outputs = list.map((attribute) => output_of_attribute(attribute, list));
      }
      layout.add_stream(head, this.#row(i), this.#stitch[i], place_of_stream, outputs);
    }
  }
}
