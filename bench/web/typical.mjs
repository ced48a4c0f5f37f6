// Measures decoders of Draco streams on assets as they are shipped, in one process, in turn:  node typical.mjs ROUNDS GLB...
//
// Prints the table of docs/measured/web.md. Each asset's primitives are decoded one after the other, as a loader does. Each decoder has an
// instance of its own for all assets. Times are medians of the rounds after the first ones; a ratio is the median of the rounds'
// ratios.
import path from 'node:path';
import { compressed_primitives } from '../../tests/web/load.mjs';
import { measured } from './cpu_time.mjs';
import { calling_thread } from './decoders.mjs';

const [rounds, ...files] = process.argv.slice(2), kWarmUpRounds = 4, kLeastMs = 40;
const kNames = ['draco3d 1.5.7', "three's draco_decoder", 'psplit/draco', 'psplit, one stream'];
const decoders = (await calling_thread([])).filter(({ name }) => kNames.includes(name));
const instances = await Promise.all(decoders.map(({ create }) => create()));

const median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];
const geometric_mean = (values) => Math.exp(values.reduce((sum, value) => sum + Math.log(value), 0) / values.length);

const of_assets = [];
for (const file of files) {
  const primitives = compressed_primitives(file, 'KHR_draco_mesh_compression'), run = (i) => primitives.forEach((of) => instances[i].run(of));
  const start = performance.now();
  for (let i = 0; i < 3; ++i) run(0);
  const times = Math.max(1, Math.ceil(kLeastMs / ((performance.now() - start) / 3))), ms = decoders.map(() => []);
  for (let round = -kWarmUpRounds; round < rounds; ++round)
    for (const i of decoders.keys()) {
      const { main } = await measured(async () => {
        for (let left = times; left > 0; --left) run(i);
      });
      if (round >= 0) ms[i].push(main / times);
    }
  of_assets.push({ name: path.basename(file, '.glb'), primitives, ms, ratios: ms.map((all) => median(all.map((time, round) => ms[0][round] / time))) });
}

console.log(`| asset | primitives | bytes | ${decoders.map(({ name }, i) => (i === 0 ? `${name}, CPU ms` : `${name}, times`)).join(' | ')} |`);
console.log(`|---|${'---:|'.repeat(2 + decoders.length)}`);
for (const { name, primitives, ms, ratios } of of_assets)
  console.log(`| ${name} | ${primitives.length} | ${primitives.reduce((sum, { bytes }) => sum + bytes.length, 0).toLocaleString('en-US')} | ${
    ratios.map((ratio, i) => (i === 0 ? median(ms[0]).toFixed(2) : ratio.toFixed(2))).join(' | ')} |`);
const of = (use) => decoders.map((_, i) => (i === 0 ? '' : use(of_assets.map(({ ratios }) => ratios[i])).toFixed(2))).join(' | ');
console.log(`| geometric mean | | | ${of(geometric_mean)} |`);
console.log(`| worst | | | ${of((ratios) => Math.min(...ratios))} |`);
