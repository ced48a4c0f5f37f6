// What JavaScript reads of a container: the directory and the heads of its streams. The rest is decoded on the
// device. A container that the device does not decode is refused.
import { kSemantics, kTypes } from '../types.js';
import { are_justified, read_directory } from './directory.js';
import { add_record_words, kBoundsWords, kGridWords, kNone, kStateWords, Layout, stream_words } from './layout.js';
import { refuse } from './refusal.js';
import { code, stages } from './shaders.js';
import { kCodingInteger, kCodingQuantized, Reader, read_stream_head } from './stream_head.js';

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

/** What depends on the kind of streams: Draco's. condensed.js has the other kind. */
export const draco = { is_condensed: false, code, stages, Layout, stream_words, add_record_words, read_directory,
  read_head: (reader, { stream_at, faces }, i, last) => read_stream_head(reader, stream_at[i], stream_at[i + 1], faces[i], last) };

export class ContainerPlan {
  // Where a batch has it.
  bytes_at = 0;
  first_stream = 0;
  indices = 0;
  #bytes;
  #heads;  // of streams, with their counts
  #words;       // of the memory of streams
  #sizes = null;

  /**
   * @param {Uint8Array} bytes
   * @param {object[] | undefined} attributes those that are wanted; by default all of the first stream
   * @param {'float32' | 'quantized'} as how quantized values are written
   * @param {number} most_words of memory for a stream
   * @param {object} kind of the streams
   */
  constructor(bytes, attributes, as, most_words, kind = draco) {
    this.kind = kind;
    const directory = (this.directory = kind.read_directory(bytes));
    this.#bytes = bytes;
    if (directory.has_residue) refuse('a residue');
    const reader = new Reader(bytes);
    this.#words = new Uint32Array(directory.stream_count);
    this.#heads = new Array(directory.stream_count);
    for (let i = 0; i < directory.stream_count; ++i) this.#read_stream(reader, i, most_words);
    this.attributes = attributes ?? stored(this.#heads[0]);
    // The first stream says how values are written; others must say the same. Streams mostly have one list of attributes.
    const lists = [], heads = this.#heads;
    let list;
    for (let i = 0; i < heads.length; ++i) if (heads[i].attributes !== list) lists.push((list = heads[i].attributes));
    this.outputs = [];  // not by map(): V8 would compile the loops over streams again for another kind of array
    for (const request of this.attributes) {
      const found = lists.map((all) => all.find(({ unique_id }) => unique_id === request.uniqueId) ?? refuse('an attribute that is missing'));
      const outputs = found.map((attribute) => output_of(attribute, request, as)), { is_grid, out_bytes } = outputs[0];
      if (outputs.some((other) => other.is_grid !== is_grid) || (is_grid && found.some(({ coding }) => coding !== kCodingQuantized)))
        refuse('streams with other codings than the first');
      const is_bounded = found.every(({ semantic, coding, components }) => semantic === 0 && coding === kCodingQuantized && components === 3);
      this.outputs.push({ request, is_grid, out_bytes, is_bounded, coding: found[0].coding, stride: Math.ceil((out_bytes * request.componentCount) / 4),
        out: 0, grids: undefined, bounds: undefined });  // places, in a batch
    }
    if (this.attributes.some(({ uniqueId }, i) => this.attributes.findIndex((other) => other.uniqueId === uniqueId) < i)) refuse('an attribute that is wanted twice');
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
    const { plan_words = 0 } = this.directory, sizes = [plan_words, 0, 0, 0, this.result_words, kStateWords * this.stream_count];
    for (let i = 0; i < this.stream_count; ++i) this.kind.add_record_words(sizes, this.#heads[i]);
    for (const { coding, is_bounded } of this.outputs)
      sizes[5] += (coding === kCodingQuantized ? kGridWords * this.stream_count : 0) + (is_bounded ? kBoundsWords : 0);
    return sizes;
  }

  #read_stream(reader, i, most_words) {
    const { faces, points, references } = this.directory;
    if (faces[i] > kMostFacesOfAStream) refuse('a stream of many faces');
    const head = this.kind.read_head(reader, this.directory, i, i > 0 ? this.#heads[i - 1] : undefined);
    head.point_count = points[i];
    head.reference_count = references[i];
    const words = this.kind.stream_words(head);
    if (words > most_words) refuse('a stream that takes much memory');
    this.#words[i] = words;
    this.#heads[i] = head;
  }

  /**
   * Adds the streams to a batch.
   * @param {import('./layout.js').Layout} layout
   * @param {number} bytes_at the place of the container in the batch's bytes
   */
  place(layout, bytes_at) {
    const { directory } = this, first_stream = (this.first_stream = layout.streams_added);
    this.indices = layout.take_results(3 * this.face_count);
    for (const output of this.outputs) {
      output.out = layout.take_results(output.stride * this.point_count);
      if (output.coding === kCodingQuantized) output.grids = layout.take_states(kGridWords * this.stream_count);
      if (output.is_bounded) output.bounds = layout.take_states(kBoundsWords);
    }
    const output_of_attribute = (attribute, all) => {
      const k = this.attributes.findIndex(({ uniqueId }) => uniqueId === attribute.unique_id), output = this.outputs[k];
      // Of several attributes with this id, the first one is meant.
      if (k < 0 || all.find(({ unique_id }) => unique_id === attribute.unique_id) !== attribute) return kNoOutput;
      return { out: output.out, out_bytes: output.out_bytes, stride: output.stride, is_grid: output.is_grid ? 1 : 0,
        grid: output.grids ?? 0, bounds: output.bounds ?? kNone };
    };
    const place = { bytes_at, mesh_points: this.point_count, has_walk: directory.has_references ? 1 : 0, first_stream, indices: this.indices };
    let list, outputs;
    for (let i = 0; i < this.stream_count; ++i) {
      const head = this.#heads[i];
      if (head.attributes !== list) {
        list = head.attributes;
        outputs = [];
        for (const attribute of list) outputs.push(output_of_attribute(attribute, list));
      }
      layout.add_stream(head, this.#words[i], place, outputs, i, directory);
    }
  }
}
