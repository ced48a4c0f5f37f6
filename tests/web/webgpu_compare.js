// Compares what a GPU decodes with what WebAssembly decodes, in Node.js and in pages.
export const are_equal = (a, b) => {
  const x = new Uint8Array(a.buffer, a.byteOffset, a.byteLength), y = new Uint8Array(b.buffer, b.byteOffset, b.byteLength);
  return x.length === y.length && x.every((byte, i) => byte === y[i]);
};
/** What differs between two decoded meshes, or undefined. */
export function difference(expected, found) {
  if (!are_equal(expected.indices, found.indices)) return 'indices';
  return expected.attributes.find(({ array }, i) => !are_equal(array, found.attributes[i].array))?.name;
}

/**
 * Decodes containers in one call, and compares each.
 * @param {object} decoder of createGpuDecoder
 * @param {Function} decodeContainer
 * @param {{ name: string, bytes: Uint8Array, attributes?: object[] }[]} containers
 * @returns {Promise<{ equal: number, by_wasm: number, refused: number, differences: string[], reasons: string[] }>}
 */
export async function compare(decoder, decodeContainer, containers) {
  const counts = { equal: 0, by_wasm: 0, refused: 0, differences: [], reasons: [] };
  const results = await decoder.decode(containers.map(({ bytes }) => bytes), { attributes: containers.map(({ attributes }) => attributes) });
  for (const [i, { name, bytes, attributes }] of containers.entries()) {
    const result = results[i], expected = await decodeContainer(bytes, { attributes }).catch((error) => error);
    if (expected instanceof Error || result instanceof Error) {
      if (expected.message === result.message) ++counts.refused;
      else counts.differences.push(`${name}: ${result.message ?? result.way} instead of ${expected.message ?? 'a mesh'}`);
    } else {
      const what = difference(expected, await result.read());
      if (what !== undefined) counts.differences.push(`${name}: ${what} by ${result.way}`);
      else if (result.way === 'gpu') ++counts.equal;
      else ++counts.by_wasm, counts.reasons.push(`${name}: ${result.why}`);
    }
    result.destroy?.();
  }
  return counts;
}
export const add = (sum, more) => {
  for (const [name, value] of Object.entries(more)) sum[name] = Array.isArray(value) ? [...(sum[name] ?? []), ...value] : (sum[name] ?? 0) + value;
  return sum;
};
