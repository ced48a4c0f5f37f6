// Measures decoders of the web on the same meshes, in one process, in turn:
//
//   node bench.mjs FOLDER ROUNDS [--only NAMES] [--rival FILE]...
//
// The folder has generated meshes, and assets whose names begin with "asset-". Prints a line of JSON for each measurement, which
// scripts/web-bench makes the tables of. Each decoder has an instance of its own. Its first calls are not counted: code is
// compiled while they run.
import { parseArgs } from 'node:util';
import { brotliCompressSync } from 'node:zlib';
import { close_browser } from '../../tests/web/browser.mjs';
import { measured } from './cpu_time.mjs';
import { calling_thread, code_of_encoders, code_of_pages, in_workers } from './decoders.mjs';
import { first_mesh } from './first_mesh.mjs';
import { names_in, read_mesh, read_primitives } from './meshes.mjs';

const { values: { only, rival: rivals }, positionals: [folder, argument] } = parseArgs({ allowPositionals: true,
  options: { only: { type: 'string', default: 'thread,workers,page' }, rival: { type: 'string', multiple: true, default: [] } } });
const rounds = Number(argument), names = only === 'code' ? [] : names_in(folder), is_asset = (name) => name.startsWith('asset-');
const print = (line) => console.log(JSON.stringify(line));

// V8 compiles the code of each pool again, with optimization, after a dozen decodes; with two workers later than with one.
const kWarmUpRounds = 4, kWarmUpRoundsOfPools = 15, kLeastMs = 40;

// Rounds of all decoders in turn, each of which decodes all primitives one after the other. Prints the milliseconds of each round by
// decoder: CPU time of this thread, and of the busiest other thread.
async function run_rounds(what, list, name, warm_up_rounds) {
  const { primitives, bytes } = await read_mesh(folder, name, list.map(({ stored }) => stored)), results = list.map(() => []), heap = [], instances = [];
  for (const decoder of list) instances.push(await decoder.create());
  const decode = async (i) => { for (const primitive of primitives[list[i].stored]) await instances[i].run(primitive); };
  // Small meshes several times, to be measurable.
  await decode(0);
  const start = performance.now();
  await decode(0);
  const runs = Math.ceil(kLeastMs / (performance.now() - start));
  for (let round = -warm_up_rounds; round < rounds; ++round)
    for (const i of list.keys()) {
      const { main, busiest } = await measured(async () => { for (let left = runs; left > 0; --left) await decode(i); });
      if (round >= 0) results[i].push({ main: main / runs, busiest: busiest / runs });
      // psplit/draco gives memory back.
      heap[i] = Math.max(heap[i] ?? 0, instances[i].memory?.() ?? 0);
    }
  const of_decoder = (i) => ({ main: results[i].map(({ main }) => main), busiest: results[i].map(({ busiest }) => busiest), bytes: bytes[list[i].stored],
    heap: heap[i] || undefined });
  print({ what, name: name.replace('asset-', ''), decoders: Object.fromEntries(list.map((decoder, i) => [decoder.name, of_decoder(i)])) });
  for (const instance of instances) instance.end?.();
}

const measurements = {
  async thread() {
    const decoders = await calling_thread(rivals);
    // Assets are measured as they are shipped: one stream for each primitive.
    for (const name of names)
      if (is_asset(name)) await run_rounds('asset', decoders.filter(({ stored }) => stored === 'stock'), name, kWarmUpRounds);
      else await run_rounds('thread', decoders, name, kWarmUpRounds);
  },
  async workers() {
    for (const name of names.filter((name) => !is_asset(name))) await run_rounds('workers', in_workers(), name, kWarmUpRoundsOfPools);
  },
  // In Chromium: wall time, from the begin of a page until its arrays are there.
  async page() {
    for (const name of ['small', 'terrain']) {
      const [[stock], [patches]] = await Promise.all(['stock', 'patches'].map((stored) => read_primitives(folder, name, stored)));
      print({ what: 'page', name, ms: await first_mesh({ stream: stock.bytes, container: patches.bytes, attributes: patches.attributes }, rounds) });
    }
    await close_browser();
  },
  // The code that a page loads: bytes, and bytes in brotli.
  async code() {
    const total = (parts, bytes_of) => parts.reduce((sum, part) => sum + bytes_of(part), 0);
    const sizes = ([name, parts]) => [name, total(parts, (part) => part.length), total(parts, (part) => brotliCompressSync(part).length)];
    print({ what: 'code', decoders: (await code_of_pages(rivals)).map(sizes), encoders: (await code_of_encoders()).map(sizes) });
  },
};
for (const name of only.split(',')) await measurements[name]();
