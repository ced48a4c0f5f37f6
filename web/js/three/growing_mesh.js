// The arrays of a mesh that is shown while its patches arrive. They have their final size from the beginning. All indices
// are 0 at first, so that no triangle is drawn; each part writes its points and its triangles.
import { PsplitError } from '../error.js';
import { copy_elements } from './aligned.js';

// The specification's limit for the arrays of a mesh of a container with that many bytes.
const justified_bytes = (container_bytes) => 64 * 2 ** 20 + 4096 * container_bytes;

export class GrowingMesh {
  #container;
  #changed;
  #arrays = null;
  #begun;

  /**
   * @param {Container} container
   * @param {(column: Column, first: number, count: number) => void} changed components of an array changed
   */
  constructor(container, changed) {
    this.#container = container;
    this.#changed = changed;
    // Resolves to the buffers of the container's synthetic views when the first part arrives.
    this.buffers = new Promise((resolve) => (this.#begun = resolve));
  }
  get has_begun() {
    return this.#arrays !== null;
  }

  // A part of Pool.decodePatches. Its faces have points of parts that have come.
  add({ firstPoint, attributes, firstFace, indices }, container_bytes) {
    if (this.#arrays === null) this.#begin(container_bytes);
    for (const [i, column] of this.#container.attributes.entries()) this.#write(column, attributes[i].array, firstPoint);
    this.#write(this.#container.indices, indices, 3 * firstFace);
  }

  // Hides all triangles: a part of a mesh must not be taken for the whole.
  clear() {
    if (this.#arrays === null) return;
    const { indices } = this.#container;
    this.#arrays.get(indices).fill(0);
    this.#changed(indices, 0, indices.count);
  }

  // The counts are those of the accessors. When the mesh is whole, they are compared with it.
  #begin(container_bytes) {
    const { columns } = this.#container;
    if (columns.reduce((sum, { bytes }) => sum + bytes, 0) > justified_bytes(container_bytes))
      throw new PsplitError('the accessors have more elements than the bytes of the container can justify', 'invalid-input');
    this.#arrays = new Map(columns.map((column) => [column, column.make_array()]));
    this.#begun(new Map([...this.#arrays].map(([column, array]) => [column.view, array.buffer])));
  }

  #write(column, values, first) {
    const { components, stride, count } = column;
    if (first + values.length / components > count)
      throw new PsplitError('the patches have more points or faces than the accessors', 'invalid-input');
    copy_elements(values, components, this.#arrays.get(column), stride, first);
    this.#changed(column, first * stride, (values.length / components) * stride);
  }
}
