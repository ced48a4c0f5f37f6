// Measures decoders of the web on the same meshes, in one process, in turn:
//
//   node bench.mjs FOLDER ROUNDS [--rival FILE]...     the tables of docs/web.md, as Markdown
//   node bench.mjs --first NUMBER FOLDER MESH [--rival FILE]...   the CPU time that decoder NUMBER takes for a page's first mesh
//
// Each decoder has an instance of its own. Its first calls are not counted: code is compiled while they run. Times are medians
// of the rounds after them. A ratio is the median of the rounds' ratios, so that what slows the machine down slows both.
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { brotliCompressSync } from 'node:zlib';
import { measured } from './cpu_time.mjs';
import { calling_thread, in_workers } from './decoders.mjs';
import { names_in, read_mesh, read_primitive } from './meshes.mjs';

const { values: { first, rival: rivals }, positionals: [folder, argument] } = parseArgs({ allowPositionals: true,
  options: { first: { type: 'string' }, rival: { type: 'string', multiple: true, default: [] } } });
const decoders = await calling_thread(rivals);

const median = (values) => values.toSorted((a, b) => a - b)[values.length >> 1];
const geometric_mean = (values) => Math.exp(values.reduce((sum, value) => sum + Math.log(value), 0) / values.length);
const fixed = (value, digits = 1) => value.toFixed(digits), count = (value) => Math.round(value).toLocaleString('en-US');

if (first !== undefined) {
  const decoder = decoders[first], primitive = await read_primitive(folder, argument, decoder.stored);
  const { main, all } = await measured(async () => (await decoder.create()).run(primitive));
  console.log(JSON.stringify([main, all]));
  process.exit();
}

function print_table(header, rows) {
  console.log(`| ${header.join(' | ')} |\n|${header.map((_, i) => (i === 0 ? '---' : '---:')).join('|')}|`);
  for (const row of rows) console.log(`| ${row.join(' | ')} |`);
  console.log();
}

// Rounds of all decoders in turn. Returns, by decoder, the medians, and the times of the first decoder divided by its own.
// `cost` is the CPU time of the calling thread, and in workers that of the busiest worker as well.
async function run_rounds(list, mesh, rounds) {
  const instances = [];
  for (const decoder of list) instances.push(await decoder.create());
  const results = list.map(() => []), runs = Math.ceil(50000 / mesh.faces);  // small meshes several times, to be measurable
  for (let round = -kWarmUpRounds; round < rounds; ++round) {
    for (const [i, { stored }] of list.entries()) {
      const result = await measured(async () => {
        for (let left = runs; left > 0; --left) await instances[i].run(mesh[stored]);
      });
      for (const key of Object.keys(result)) result[key] /= runs;
      if (round >= 0) results[i].push({ ...result, cost: result.main + (list === workers ? result.busiest : 0) });
    }
  }
  const summary = results.map((times, i) => ({
    ...Object.fromEntries(Object.keys(times[0]).map((key) => [key, median(times.map((time) => time[key]))])),
    ratio: median(times.map(({ cost }, round) => results[0][round].cost / cost)),
    wall_ratio: median(times.map(({ wall }, round) => results[0][round].wall / wall)),
    memory: instances[i].memory?.(),
  }));
  for (const instance of instances) instance.end?.();
  return summary;
}

const kWarmUpRounds = 3, rounds = Number(argument), names = names_in(folder), workers = in_workers();
const ratios = new Map(), of_workers = new Map();  // by decoder
const add = (map, list, summary) => list.forEach(({ name }, i) => map.set(name, [...map.get(name) ?? [], summary[i]]));
const is_generated = (name) => !name.startsWith('corpus-');
const worker_tables = [];

for (const name of names) {
  const mesh = await read_mesh(folder, name);
  const title = `${name}: ${count(mesh.faces)} faces, ${mesh.attributes.join(', ')}`;
  const summary = await run_rounds(decoders, mesh, rounds);
  add(ratios, decoders, summary);
  const bytes_of = (stored) => (stored === 'meshopt' ? `${count(mesh.meshopt.bytes.length)} (${count(mesh.meshopt.zstd_bytes)} with zstd)`
    : count(mesh[stored].bytes.length));
  if (is_generated(name)) {
    console.log(`### ${title}\n`);
    print_table(['decoder', 'bytes of the mesh', 'CPU ms', `times ${decoders[0].name}`, 'wall ms', 'heap, MiB'], decoders.map(({ name, stored }, i) =>
      [name, bytes_of(stored), fixed(summary[i].cost), fixed(summary[i].ratio, 2), fixed(summary[i].wall),
        summary[i].memory === undefined ? '' : fixed(summary[i].memory / 2 ** 20)]));
    const in_pool = await run_rounds(workers, mesh, rounds);
    add(of_workers, workers, in_pool);
    worker_tables.push([title, workers.map(({ name }, i) => [name, fixed(in_pool[i].main), fixed(in_pool[i].busiest), fixed(in_pool[i].ratio, 2),
      fixed(in_pool[i].wall), fixed(in_pool[i].wall_ratio, 2)])]);
  }
}

console.log(`### All ${ratios.get(decoders[0].name).length} meshes: times ${decoders[0].name}\n`);
print_table(['decoder', 'CPU time, geometric mean', 'worst', 'heap, geometric mean', 'largest'], decoders.map(({ name }) => {
  const all = ratios.get(name), heaps = all.map(({ memory }, i) => memory / ratios.get(decoders[0].name)[i].memory);
  return [name, fixed(geometric_mean(all.map(({ ratio }) => ratio)), 2), fixed(Math.min(...all.map(({ ratio }) => ratio)), 2),
    ...(all[0].memory === undefined ? ['', ''] : [fixed(geometric_mean(heaps), 2), fixed(Math.max(...heaps), 2)])];
}));

console.log('### In workers: CPU time of the main thread and of the busiest worker\n');
for (const [title, rows] of worker_tables) {
  console.log(`${title}\n`);
  print_table(['loader', 'main ms', 'busiest worker ms', `both, times ${workers[0].name}`, 'wall ms', 'wall, times'], rows);
}

console.log('### The first mesh of a page: CPU time of loading the decoder and decoding, each in a process of its own\n');
const script = fileURLToPath(import.meta.url), kFirstRounds = 5, firsts = names.filter(is_generated);
const of_first = decoders.map(() => firsts.map(() => []));
for (let round = 0; round < kFirstRounds; ++round)
  for (const [d] of decoders.entries())
    for (const [m, name] of firsts.entries())
      of_first[d][m].push(JSON.parse(execFileSync(process.execPath, [script, '--first', d, folder, name, ...rivals.flatMap((file) => ['--rival', file])])));
for (const [m, name] of firsts.entries()) {
  const time = (d, which) => median(of_first[d][m].map((times) => times[which]));
  console.log(`${name}\n`);
  print_table(['decoder', 'main thread, ms', `times ${decoders[0].name}`, 'all threads, ms', 'times'], decoders.map(({ name }, d) =>
    [name, ...[0, 1].flatMap((which) => [fixed(time(d, which)), fixed(time(0, which) / time(d, which), 2)])]));
}

console.log('### Code that a page loads\n');
const brotli = (file) => brotliCompressSync(readFileSync(file)).length;
print_table(['decoder', 'files', 'bytes', 'brotli'], decoders.filter(({ code }, i) => decoders.findIndex((other) => `${other.code}` === `${code}`) === i)
  .map(({ name, code }) => [name, code.map((file) => path.basename(file)).join(', '), count(code.reduce((sum, file) => sum + readFileSync(file).length, 0)),
    count(code.reduce((sum, file) => sum + brotli(file), 0))]));
