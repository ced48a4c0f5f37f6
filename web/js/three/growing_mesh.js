// The arrays of a mesh that is shown while its patches arrive. They have their final size from the beginning. All indices
// are 0 at first, so that no triangle is drawn; each part writes its points and its triangles.
import { copy_elements } from './aligned.js';

export class GrowingMesh {
  #container;
  #arrays = null;
  #present;       // whether each point of the mesh has arrived
  #waiting = [];  // parts with triangles that have points of parts that have not arrived
  #begun;

  /**
   * @param {Container} container
   * @param {(column: Column, first: number, count: number) => void} changed components of an array changed
   */
  constructor(container, changed) {
    this.#container = container;
    this.changed = changed;
    // Resolves to the buffers of the container's synthetic views when the first part arrives.
    this.buffers = new Promise((resolve) => (this.#begun = resolve));
  }
  get has_begun() {
    return this.#arrays !== null;
  }

  /** @param {object} part of Pool.decodePatches @param {object} mesh the counts of the mesh */
  add(part, mesh) {
    if (this.#arrays === null) this.#begin(mesh);
    const { firstPoint, pointCount, attributes } = part;
    for (const [i, column] of this.#container.attributes.entries()) this.#write(column, attributes[i].array, firstPoint);
    this.#present.fill(1, firstPoint, firstPoint + pointCount);
    this.#waiting.push({ ...part, checked: 0 });
    this.#waiting = this.#waiting.filter((candidate) => {
      if (!this.#has_points_of(candidate)) return true;
      this.#write(this.#container.indices, candidate.indices, 3 * candidate.firstFace);
      return false;
    });
  }

  #has_points_of(part) {
    const { indices } = part;
    while (part.checked < indices.length && this.#present[indices[part.checked]] === 1) ++part.checked;
    return part.checked === indices.length;
  }

  // Hides all triangles: a part of a mesh must not be taken for the whole.
  clear() {
    if (this.#arrays === null) return;
    const { indices } = this.#container;
    this.#arrays.get(indices).fill(0);
    this.changed(indices, 0, indices.count);
  }

  #begin(mesh) {
    this.#container.check(mesh);
    this.#present = new Uint8Array(mesh.pointCount);
    this.#arrays = new Map(this.#container.columns.map((column) => [column, column.make_array()]));
    this.#begun(new Map([...this.#arrays].map(([column, array]) => [column.view, array.buffer])));
  }

  #write(column, values, first) {
    const { components, stride } = column;
    copy_elements(values, components, this.#arrays.get(column), stride, first);
    this.changed(column, first * stride, (values.length / components) * stride);
  }
}
