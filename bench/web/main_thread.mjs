// The CPU time of the page's thread for containers: in psplit/webgpu, what JavaScript does before the device decodes, and decoding by WebAssembly
// on one thread. Linux only.
//
//   node bench/web/main_thread.mjs FILE...    GLBs of patches; prints a row for each: the first call, and the median of nine
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, package_folder, psplit } from '../../tests/web/load.mjs';
import { measured } from './cpu_time.mjs';

const of_package = (name) => import(pathToFileURL(path.join(package_folder, 'webgpu', name)));
const { batches_of, fits } = await of_package('batch.js'), { ContainerPlan } = await of_package('container_plan.js'), { Layout } = await of_package('layout.js');
const kRounds = 9, kMemory = 128 * 1024 * 1024, median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];

console.log('| file | bytes | patches | records: first, ms | median, ms | WebAssembly: first, ms | median, ms | memory, MB | windows |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|');
for (const file of process.argv.slice(2)) {
  const containers = compressed_primitives(file, 'PSPLIT_mesh_draco_patches'), records = [], decodes = [];
  let plans, layout;
  for (let round = 0; round < kRounds; ++round) {
    records.push((await measured(async () => {
      plans = containers.map(({ bytes, attributes }) => new ContainerPlan(bytes, attributes, 'float32', kMemory / 4));
      if (!plans.every((plan) => fits(plan, 2 ** 30)) || batches_of(plans, 2 ** 30).length > 1) throw new Error(`${file}: more than a batch`);
      layout = new Layout(kMemory / 4, plans);
      for (const plan of plans) plan.place(layout, 0);
    })).main);
    decodes.push((await measured(async () => {
      for (const { bytes, attributes } of containers) await psplit.decodeContainer(bytes, { attributes });
    })).main);
  }
  const all = new Layout(2 ** 30, plans);
  for (const plan of plans) plan.place(all, 0);
  const numbers = [records[0], median(records), decodes[0], median(decodes)].map((ms) => ms.toFixed(1));
  console.log(`| ${path.basename(file)} | ${readFileSync(file).length.toLocaleString('en-US')} | ${plans.reduce((sum, { stream_count }) => sum + stream_count, 0).toLocaleString('en-US')} | ${numbers.join(' | ')} | ${(4e-6 * all.memory_words).toFixed(0)} | ${layout.windows.length} |`);
}
