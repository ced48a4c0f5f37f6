// What a page can know of the costs of loading a model: its main thread's time, and memory.

const kBeatMs = 1, kLeastMs = 4, kMostWaitMs = 3000;

/** Watches the page's main thread: when a turn comes kLeastMs late, it was blocked. Returns a function that ends this. */
export function watch_main_thread() {
  const { port1, port2 } = new MessageChannel();
  let last = performance.now(), blocked = 0, longest = 0, timer;
  const count = () => {
    const now = performance.now(), late = now - last - kBeatMs;
    if (late >= kLeastMs) blocked += late, (longest = Math.max(longest, late));
    last = now;
  };
  // A timer that a timer starts waits for 4 ms or more, one that a message starts does not.
  const wait = () => (timer = setTimeout(() => port2.postMessage(null), kBeatMs));
  port1.onmessage = () => {
    count();
    wait();
  };
  wait();
  return () => {
    count();
    clearTimeout(timer);
    port1.close();
    return { blocked, longest };
  };
}

/** Counts the bytes of the buffers that are made on a device from now on: those it has `now`, and the `most` at one time. */
export function count_buffers(device) {
  const counts = { now: 0, most: 0 }, { createBuffer } = device;
  device.createBuffer = (descriptor) => {
    const buffer = createBuffer.call(device, descriptor), { destroy, size } = buffer;
    let is_there = true;
    counts.most = Math.max(counts.most, (counts.now += size));
    buffer.destroy = () => {
      if (is_there) counts.now -= size;
      is_there = false;
      destroy.call(buffer);
    };
    return buffer;
  };
  return counts;
}

/** Makes a worker for a pool, whose name worker_memory() takes. */
export const make_worker = (name) => new Worker('counting_worker.js', { type: 'module', name });
/** The bytes of WebAssembly's memory in the `count` workers of a name; undefined if they do not answer. */
export async function worker_memory(name, count) {
  const channel = new BroadcastChannel(name);
  let sum = 0, left = count;
  try {
    return await new Promise((resolve) => {
      channel.onmessage = ({ data }) => {
        if (typeof data !== 'number') return;
        sum += data;
        if (--left === 0) resolve(sum);
      };
      if (left === 0) resolve(0);
      channel.postMessage('how much?');
      setTimeout(resolve, kMostWaitMs);
    });
  } finally {
    channel.close();
  }
}
/** Answers worker_memory() in a worker. */
export function answer_in_worker() {
  const memories = [], { Instance } = WebAssembly, channel = new BroadcastChannel(globalThis.name);
  WebAssembly.Instance = function (...given) {
    const instance = new Instance(...given);
    memories.push(instance.exports.memory);
    return instance;
  };
  channel.onmessage = ({ data }) => {
    if (typeof data !== 'number') channel.postMessage(memories.reduce((bytes, { buffer }) => bytes + buffer.byteLength, 0));
  };
}

/** The bytes of the arrays that meshes keep in JavaScript. */
export function array_bytes(meshes) {
  const buffers = new Set();
  for (const { geometry: { index, attributes, morphAttributes } } of meshes)
    for (const attribute of [index, ...Object.values(attributes), ...Object.values(morphAttributes).flat()])
      if (attribute) buffers.add((attribute.data ?? attribute).array.buffer);
  return [...buffers].reduce((sum, { byteLength }) => sum + byteLength, 0);
}
