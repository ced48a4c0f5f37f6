// What the first bytes of a container say.

export const kHeaderBytes = 20;
const kMagic = 0x4c505350;

// Where the head begins and ends. Both are 0 if the present bytes are not a container's.
export function head_of(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), word = (at) => view.getUint32(at, true);
  const begin = kHeaderBytes + word(12);
  return word(0) === kMagic ? { begin, end: begin + word(16) } : { begin: 0, end: 0 };
}

// The bytes to the end of the head; 0 if they are not a container's: then no more are needed.
export const front_bytes = (bytes) => (bytes.length < kHeaderBytes ? kHeaderBytes : head_of(bytes).end);

// Where the head begins, or 0.
export const head_begin = (bytes) => (bytes.length < kHeaderBytes ? 0 : head_of(bytes).begin);
// Whether streams of a container are condensed: then its head begins with their tables.
export function is_condensed(bytes) {
  const kTables = 1, begin = head_begin(bytes), end = front_bytes(bytes);
  return begin > 0 && begin < Math.min(end, bytes.length) && bytes[begin] === kTables;
}
