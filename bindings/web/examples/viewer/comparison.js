// Decode times of the same mesh by psplit and by draco3d, in this browser.
import { createPool } from './psplit/index.js';

const kMostMs = 3000, kLeastRounds = 3, kMostRounds = 15;

// Workers that run draco3d, each one stream after the other.
class Draco3d {
  constructor(count) {
    this.workers = Array.from({ length: count }, () => new Worker('draco3d_worker.js'));
  }
  async decode(streams) {
    const waiting = [...streams], arrays = [];
    await Promise.all(this.workers.map(async (worker) => {
      for (let stream; (stream = waiting.shift()) !== undefined;) arrays.push(await this.#run(worker, stream));
    }));
    return arrays;
  }
  #run(worker, { bytes, attributes }) {
    return new Promise((resolve, reject) => {
      worker.onmessage = ({ data: { arrays, error } }) => (error === undefined ? resolve(arrays) : reject(new Error(error)));
      worker.onerror = (event) => reject(new Error(event.message ?? 'draco3d cannot be loaded'));
      worker.postMessage({ bytes, attributes });
    });
  }
  dispose() {
    for (const worker of this.workers) worker.terminate();
  }
}

class Psplit {
  constructor(workers) {
    this.pool = createPool({ workers });
  }
  decode(streams) {
    return Promise.all(streams.map(({ kind, bytes, attributes }) =>
      (kind === 'draco' ? this.pool.decodeDraco(bytes, { attributes }) : this.pool.decodeContainer(bytes, { attributes }))));
  }
  dispose() {
    this.pool.dispose();
  }
}

// The number that a part of the numbers do not exceed.
const quantile = (numbers, part) => numbers.toSorted((a, b) => a - b)[Math.floor(part * (numbers.length - 1))];
const median = (numbers) => quantile(numbers, 0.5);
// Half of the numbers lie within this part of their median.
const spread = (numbers) => (quantile(numbers, 0.75) - quantile(numbers, 0.25)) / 2 / median(numbers);

/**
 * Times contenders in turn, from the posting of bytes to the arrival of arrays. The first round warms up and does not count.
 * @param {{decoder: object, streams: object[]}[]} contenders
 * @returns {Promise<{rounds: number, times: number[], noise: number}>} medians in milliseconds, and the largest spread
 */
async function measure(contenders, signal) {
  const times = contenders.map(() => []), begin = performance.now();
  let rounds = -1;
  for (; rounds < kMostRounds && (rounds < kLeastRounds || performance.now() - begin < kMostMs); ++rounds)
    for (const [i, { decoder, streams }] of contenders.entries()) {
      signal.throwIfAborted();
      const start = performance.now();
      await decoder.decode(streams);
      if (rounds >= 0) times[i].push(performance.now() - start);
    }
  return { rounds, times: times.map(median), noise: Math.max(...times.map(spread)) };
}

const workers_text = (count) => (count === 1 ? '1 worker' : `${count} workers`);

/**
 * @param {object[]} streams of the asset that is shown
 * @param {object} of
 * @param {object[] | null} of.stock streams of the same mesh in stock Draco, if the asset is in patches
 * @param {object[] | null} of.patches the patches of the asset as Draco streams of their own
 * @returns {Promise<{rows: {name: string, what: string, ms: number, factor?: number}[], rounds: number, noise: number}>} factors
 *   are over the first row's time, if draco3d is among them. Half of the times lie within `noise` of the median, as a part of it
 */
export async function compare(streams, { stock, patches, workers }, signal) {
  const contenders = [], made = [];
  const add = (Decoder, count, what, given) => {
    const decoder = new Decoder(count);
    made.push(decoder);
    contenders.push({ name: Decoder === Psplit ? 'psplit' : 'draco3d', what: `${what}, ${workers_text(count)}`, decoder, streams: given });
  };
  const is_stock = streams.every(({ kind }) => kind === 'draco');
  const reference = is_stock ? streams : stock ?? patches, is_parallel = streams.length > 1 || !is_stock;
  const name_of = (given) => (given === patches ? 'patches apart' : 'stock Draco'), own = is_stock ? 'stock Draco' : 'patches joined';
  if (reference !== null) add(Draco3d, 1, name_of(reference), reference);
  if (reference?.length > 1 && workers > 1) add(Draco3d, workers, name_of(reference), reference);
  if (stock !== null) add(Psplit, 1, 'stock Draco', stock);
  add(Psplit, 1, own, streams);
  if (workers > 1 && is_parallel) add(Psplit, workers, own, streams);
  try {
    const { rounds, times, noise } = await measure(contenders, signal);
    const has_reference = contenders[0].name === 'draco3d';
    return { rounds, noise, rows: contenders.map(({ name, what }, i) =>
      ({ name, what, ms: times[i], factor: has_reference ? times[0] / times[i] : undefined })) };
  } finally {
    for (const decoder of made) decoder.dispose();
  }
}
