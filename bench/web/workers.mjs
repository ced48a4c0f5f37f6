// Whether several workers pay for a container: wall time of one, two by transfer, and two in shared memory:
//
//   node bench/web/workers.mjs FILE.glb...
//
// Each line is one file: the bytes and faces of its first container, and medians of 40 rounds after 20, taken in turn.
import path from 'node:path';
import { compressed_primitives, psplit } from '../../tests/web/load.mjs';

const by_transfer = psplit.createPool({ workers: 2, shared: false }), in_shared = psplit.createPool({ workers: 2, shared: true });
const kWarmUpRounds = 20, kRounds = 40;
const median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];

for (const file of process.argv.slice(2)) {
  const [{ bytes, attributes }] = compressed_primitives(file, 'PSPLIT_mesh_draco_patches');
  const { faceCount } = await psplit.decodeContainer(bytes, { attributes });
  const runs = {
    'one worker': () => by_transfer.decodeContainer(bytes, { attributes, workers: 1 }),
    'two by transfer': () => by_transfer.decodeContainer(bytes, { attributes, workers: 2 }),
    'two in shared memory': () => in_shared.decodeContainer(bytes, { attributes, workers: 2 }),
  };
  const times = Object.fromEntries(Object.keys(runs).map((name) => [name, []]));
  for (let round = -kWarmUpRounds; round < kRounds; ++round)
    for (const [name, run] of Object.entries(runs)) {
      const start = performance.now();
      await run();
      if (round >= 0) times[name].push(performance.now() - start);
    }
  const columns = Object.entries(times).map(([name, values]) => `${name} ${median(values).toFixed(2)} ms`);
  console.log(`${path.basename(file)}: ${bytes.length} bytes, ${faceCount} faces, ${columns.join(', ')}`);
}
by_transfer.dispose();
in_shared.dispose();
