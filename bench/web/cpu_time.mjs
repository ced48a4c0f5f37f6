// CPU time of the threads of this process. Linux only: /proc has the nanoseconds of each thread.
import { readdirSync, readFileSync } from 'node:fs';

const never = new Int32Array(new SharedArrayBuffer(4));

// The nanoseconds of all threads, by their numbers. A thread's own number is exact only after it waited; a timer of Node.js may be due at once.
function times_of_threads() {
  // On a busy machine, a wait may end before it began.
  for (let left = 2; left > 0; --left) Atomics.wait(never, 0, 0, 1);
  const times = new Map();
  for (const id of readdirSync('/proc/self/task')) {
    try {
      times.set(Number(id), Number(readFileSync(`/proc/self/task/${id}/schedstat`, 'utf8').split(' ')[0]));
    } catch {
      // the thread ended
    }
  }
  return times;
}

/**
 * Runs something, and waits for it.
 * @returns {Promise<{main: number, busiest: number, all: number, wall: number}>} milliseconds: CPU time of this thread, of the
 *   busiest other thread, and of all threads; and wall time
 */
export async function measured(run) {
  const before = times_of_threads(), start = performance.now();
  await run();
  const wall = performance.now() - start;
  const spent = [...times_of_threads()].map(([id, time]) => [id, (time - (before.get(id) ?? 0)) / 1e6]);
  const others = spent.filter(([id]) => id !== process.pid).map(([, time]) => time);
  const [[, main]] = spent.filter(([id]) => id === process.pid);
  return { main, busiest: Math.max(0, ...others), all: main + others.reduce((sum, time) => sum + time, 0), wall };
}
