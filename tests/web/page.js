// Functions that scripts of test pages import.
export async function fetch_bytes(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status}`);
  return new Uint8Array(await response.arrayBuffer());
}

// The bytes of a text in base64.
export const bytes_of_text = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0));

// The SHA-256 of an array's bytes, as text. The bytes may be shared, which SubtleCrypto does not allow.
export async function digest(array) {
  const hash = await crypto.subtle.digest('SHA-256', new Uint8Array(array.buffer, array.byteOffset, array.byteLength).slice());
  return Array.from(new Uint8Array(hash), (byte) => byte.toString(16).padStart(2, '0')).join('');
}

// Returns the facts of a decoded mesh that tests compare.
export async function digests({ faceCount, pointCount, indices, attributes }) {
  return { faceCount, pointCount, indices: await digest(indices),
    attributes: await Promise.all(attributes.map(async ({ uniqueId, componentCount, array }) =>
      ({ uniqueId, componentCount, type: array.constructor.name, values: await digest(array) }))) };
}

// Returns how a promise settles: 'done', its error, or 'hangs' after 20 seconds.
export const outcome = (promise) => Promise.race([
  promise.then(() => 'done', ({ name, code, message }) => ({ name, code, message })),
  new Promise((resolve) => setTimeout(() => resolve('hangs'), 20000)),
]);
