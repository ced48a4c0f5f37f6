// Decoded patches, as callers of the package get them.

// Streams [first, end), of the arrays of their indices and attributes.
export function part_of(attributes, first_faces, first_points, first, end, [indices, ...values], isFinal) {
  return { patches: [first, end], isFinal, firstFace: first_faces[first], firstFaces: first_faces.slice(first, end + 1), indices,
    firstPoint: first_points[first], pointCount: first_points[end] - first_points[first], attributes: with_arrays(attributes, values) };
}
export const with_arrays = (attributes, arrays) =>
  attributes.map(({ name, uniqueId, type, componentCount, normalized = false }, i) =>
    ({ name, uniqueId, type, componentCount, normalized, array: arrays[i] }));
