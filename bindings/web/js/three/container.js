// A container of a glTF asset, and the synthetic accessors and buffer views that stand for its decoded arrays.
import { PsplitError } from '../error.js';
import { check_counts, index_type, is_all_stored, kComponentCounts, names_of, number_of, set_number, stored_primitive } from '../gltf.js';
import { aligned_stride, copy_elements } from '../aligned.js';

const kArrays = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };

/** Names of attributes that skin or morph a mesh. */
export const kOfDeformed = /^(WEIGHTS_|targets\/)/;

// The numbers of the accessors that synthetic ones replace. JSON that is parsed twice has synthetic accessors already.
const replaced = new WeakMap();

// The indices or one attribute of a primitive.
class Column {
  #published;  // the synthetic accessor, and its buffer view

  constructor(json, primitive, name) {
    const number = number_of(primitive, name);
    this.source = replaced.get(json.accessors[number]) ?? number;
    this.accessor = json.accessors[this.source];
    this.Type = kArrays[this.accessor.componentType];
    this.components = kComponentCounts[this.accessor.type];
    this.count = this.accessor.count;
    const bytes = this.Type.BYTES_PER_ELEMENT;
    // The components from one element to the next.
    this.stride = name === undefined ? 1 : aligned_stride(bytes * this.components) / bytes;
  }
  get bytes() {
    return this.count * this.stride * this.Type.BYTES_PER_ELEMENT;
  }

  // Adds a synthetic accessor and its buffer view to the JSON.
  publish(json, buffer) {
    const view = { buffer, byteLength: this.bytes };
    if (this.stride !== this.components) view.byteStride = this.stride * this.Type.BYTES_PER_ELEMENT;
    this.view = json.bufferViews.push(view) - 1;
    const accessor = { ...this.accessor, bufferView: this.view, byteOffset: 0 };
    this.number = json.accessors.push(accessor) - 1;
    replaced.set(accessor, this.source);
    this.#published = { accessor, view };
  }
  // Gives it other elements than the accessor has: `count`, and a type. To be called before the loader has the buffer view.
  resize(count, componentType = this.accessor.componentType) {
    this.count = count;
    this.Type = kArrays[componentType];
    Object.assign(this.#published.accessor, { count, componentType });
    this.#published.view.byteLength = this.bytes;
  }

  make_array() {
    return new this.Type(this.count * this.stride);
  }

  // The bytes of the buffer view. `values` have no gaps.
  buffer_of(values) {
    const is_whole = values.buffer.byteLength === values.byteLength;
    if (values instanceof this.Type && this.stride === this.components && is_whole) return values.buffer;
    const array = this.make_array();
    copy_elements(values, this.components, array, this.stride);
    return array.buffer;
  }
}

export class Container {
  #json;
  #primitive;

  /** @param {object} json the asset @param {object} primitive one that has the extension */
  constructor(json, primitive) {
    const { bufferView, attributes } = stored_primitive(json, primitive);
    if (primitive.extensions.KHR_draco_mesh_compression !== undefined)
      throw new PsplitError('the primitive has KHR_draco_mesh_compression as well', 'invalid-input');
    this.#json = json;
    this.#primitive = primitive;
    this.view = bufferView;
    this.requests = attributes;
    this.indices = new Column(json, primitive);
    this.attributes = attributes.map(({ name }) => new Column(json, primitive, name));
    // Primitives with equal keys are equal.
    this.key = JSON.stringify([bufferView, this.indices.source,
      attributes.map(({ name, uniqueId }, i) => [name, uniqueId, this.attributes[i].source]).sort()]);
    this.has_fallback = this.columns.every(({ accessor }) => accessor.bufferView !== undefined);
    this.is_rigid = !names_of(primitive).some((name) => kOfDeformed.test(name));
    this.may_choose = true;  // patches may be left out
    this.uses = [];        // the primitives that are made of it: { mesh, primitive }
    this.done = 0;         // patches
    this.total = 0;
    this.patches = null;   // facts for users, when it is decoded
    this.buffers = null;   // a promise of the bytes of synthetic buffer views, by the view's number
    this.why = undefined;  // the GPU did not decode it
  }

  get columns() {
    return [this.indices, ...this.attributes];
  }

  publish() {
    for (const column of this.columns) column.publish(this.#json, this.#json.bufferViews[this.view].buffer);
  }
  // Gives a primitive the synthetic accessors.
  assign(primitive) {
    this.may_choose &&= is_all_stored(primitive, this.requests);
    primitive.indices = this.indices.number;
    for (const [i, { name }] of this.requests.entries()) set_number(primitive, name, this.attributes[i].number);
  }

  // Throws if a decoded mesh with these counts does not fit the accessors.
  check(counts) {
    check_counts(this.#json, this.#primitive, this.requests, counts);
  }
  // Checks the counts of a decoded mesh against the accessors. For a mesh of chosen patches, the synthetic accessors get its counts.
  fit(mesh) {
    const { chosen, faceCount, pointCount } = mesh;
    if (chosen === undefined) return this.check(mesh);
    this.indices.resize(3 * faceCount, index_type(this.indices.accessor, pointCount));
    for (const column of this.attributes) column.resize(pointCount);
  }
  // The buffers of arrays that are in the order of columns.
  buffers_of(arrays) {
    return new Map(this.columns.map((column, i) => [column.view, column.buffer_of(arrays[i])]));
  }
}
