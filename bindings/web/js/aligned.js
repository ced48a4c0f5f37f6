// Elements of vertex attributes begin at multiples of 4 bytes, as glTF asks and graphics APIs prefer.

export const aligned_stride = (item_bytes) => 4 * Math.ceil(item_bytes / 4);

/**
 * Copies elements into an array whose elements have a stride.
 * @param {TypedArray} from `item_size` components for each element, without gaps
 * @param {number} item_size
 * @param {TypedArray} to the array that is written, of the same type
 * @param {number} stride components from one element of `to` to the next, at least `item_size`
 * @param {number} [first] the element of `to` that is written first
 */
export function copy_elements(from, item_size, to, stride, first = 0) {
  if (stride === item_size) return to.set(from, first * stride);
  for (let element = 0, at = first * stride; element < from.length; element += item_size, at += stride)
    for (let i = 0; i < item_size; ++i) to[at + i] = from[element + i];
}
