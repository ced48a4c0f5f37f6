// The arrays of a mesh that is shown while its patches arrive. They have their final size from the beginning. All indices
// are 0 at first, so that no triangle is drawn; each part writes its points and its triangles.
import { copy_elements } from './aligned.js';

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

  // A part of Pool.decodePatches, whose faces have points of parts that have come, and the counts of the mesh.
  add({ firstPoint, attributes, firstFace, indices }, counts) {
    if (this.#arrays === null) this.#begin(counts);
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

  #begin(counts) {
    this.#container.fit(counts);
    this.#arrays = new Map(this.#container.columns.map((column) => [column, column.make_array()]));
    this.#begun(new Map([...this.#arrays].map(([column, array]) => [column.view, array.buffer])));
  }

  #write(column, values, first) {
    const { components, stride } = column;
    copy_elements(values, components, this.#arrays.get(column), stride, first);
    this.#changed(column, first * stride, (values.length / components) * stride);
  }
}
