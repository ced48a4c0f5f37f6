// Measures decoders of the web on the same meshes, in one process, in turn:
//
//   node bench.mjs FOLDER ROUNDS [--only NAMES] [--rival FILE]...   the tables of docs/measured/web.md, as Markdown
//   node bench.mjs --first NUMBER FOLDER MESH [--rival FILE]...   the CPU time that decoder NUMBER takes for a page's first mesh
//
// Each decoder has an instance of its own. Its first calls are not counted: code is compiled while they run. Times are medians
// of the rounds after them. A ratio is the median of the rounds' ratios, so that what slows the machine down slows both.
import { execFileSync } from 'node:child_process';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';
import { brotliCompressSync } from 'node:zlib';
import { measured } from './cpu_time.mjs';
import { calling_thread, code_of_pages, in_workers } from './decoders.mjs';
import { names_in, read_mesh, read_primitive } from './meshes.mjs';

const { values: { first, only, rival: rivals }, positionals: [folder, argument] } = parseArgs({ allowPositionals: true,
  options: { first: { type: 'string' }, only: { type: 'string', default: 'warm,workers,first,page,code' },
    rival: { type: 'string', multiple: true, default: [] } } });
const decoders = await calling_thread(rivals), workers = in_workers();

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
async function run_rounds(list, mesh, rounds, warm_up_rounds) {
  const instances = [];
  for (const decoder of list) instances.push(await decoder.create());
  const results = list.map(() => []), runs = Math.ceil(200000 / mesh.faces);  // small meshes several times, to be measurable
  for (let round = -warm_up_rounds; round < rounds; ++round) {
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

// V8 compiles the code of each pool again, with optimization, after a dozen decodes; with two workers later than with one.
const kWarmUpRounds = 3, kWarmUpRoundsOfPools = 15, rounds = Number(argument), names = names_in(folder);
const is_generated = (name) => !name.startsWith('corpus-');
const title_of = (name, { faces, attributes }) => `${name}: ${count(faces)} faces, ${attributes.join(', ')}`;

async function print_warm() {
  const of_decoders = decoders.map(() => []);
  for (const name of names) {
    const mesh = await read_mesh(folder, name), summary = await run_rounds(decoders, mesh, rounds, kWarmUpRounds);
    summary.forEach((of_mesh, i) => of_decoders[i].push(of_mesh));
    if (!is_generated(name)) continue;
    const bytes_of = (stored) => (stored === 'meshopt'
      ? `${count(mesh.meshopt.bytes.length)} (${count(mesh.meshopt.zstd_bytes)} with zstd, ${count(mesh.meshopt.brotli_bytes)} with brotli)`
      : count(mesh[stored].bytes.length));
    console.log(`### ${title_of(name, mesh)}\n`);
    print_table(['decoder', 'bytes of the mesh', 'CPU ms', `times ${decoders[0].name}`, 'wall ms', 'heap, MiB'],
      decoders.map((decoder, i) =>
      [decoder.name, bytes_of(decoder.stored), fixed(summary[i].cost), fixed(summary[i].ratio, 2), fixed(summary[i].wall),
        summary[i].memory === undefined ? '' : fixed(summary[i].memory / 2 ** 20)]));
  }
  console.log(`### All ${names.length} meshes: times ${decoders[0].name}\n`);
  print_table(['decoder', 'CPU time, geometric mean', 'worst', 'heap, geometric mean', 'largest'], decoders.map(({ name }, i) => {
    const ratios = of_decoders[i].map(({ ratio }) => ratio);
    const heaps = of_decoders[i].map(({ memory }, m) => memory / of_decoders[0][m].memory);
    return [name, fixed(geometric_mean(ratios), 2), fixed(Math.min(...ratios), 2),
      ...(of_decoders[i][0].memory === undefined ? ['', ''] : [fixed(geometric_mean(heaps), 2), fixed(Math.max(...heaps), 2)])];
  }));
}

async function print_workers() {
  console.log('### In workers: CPU time of the main thread and of the busiest worker\n');
  for (const name of names.filter(is_generated)) {
    const mesh = await read_mesh(folder, name), summary = await run_rounds(workers, mesh, rounds, kWarmUpRoundsOfPools);
    console.log(`${title_of(name, mesh)}\n`);
    print_table(['loader', 'main ms', 'busiest worker ms', `both, times ${workers[0].name}`, 'wall ms', 'wall, times'],
      workers.map((loader, i) =>
      [loader.name, ...['main', 'busiest'].map((key) => fixed(summary[i][key])), fixed(summary[i].ratio, 2), fixed(summary[i].wall),
        fixed(summary[i].wall_ratio, 2)]));
  }
}

function print_first() {
  const script = fileURLToPath(import.meta.url), kRounds = 3, meshes = names.filter((name) => ['small', 'terrain'].includes(name));
  console.log('### The first mesh of a page: CPU time of loading the decoder and decoding, each in a process of its own\n');
  for (const mesh of meshes) {
    const times = decoders.map(() => []), of_rivals = rivals.flatMap((file) => ['--rival', file]);
    for (let round = 0; round < kRounds; ++round) {
      for (const d of decoders.keys())
        times[d].push(JSON.parse(execFileSync(process.execPath, [script, '--first', d, folder, mesh, ...of_rivals])));
    }
    const time = (d, which) => median(times[d].map((both) => both[which]));
    console.log(`${mesh}\n`);
    print_table(['decoder', 'main thread, ms', `times ${decoders[0].name}`, 'all threads, ms', 'times'],
      decoders.map(({ name }, d) =>
      [name, ...[0, 1].flatMap((which) => [fixed(time(d, which)), fixed(time(0, which) / time(d, which), 2)])]));
  }
}

// In Chromium: wall time, from the begin of a page until its arrays are there.
async function print_page() {
  const { first_mesh } = await import('./first_mesh.mjs'), mesh = names.includes('terrain') ? 'terrain' : names[0];
  const [stock, patches] = await Promise.all(['stock', 'patches'].map((stored) => read_primitive(folder, mesh, stored)));
  const times = await first_mesh({ stream: stock.bytes, container: patches.bytes, attributes: patches.attributes });
  console.log(`### The first mesh of a page in Chromium (${mesh}): wall time from the begin of the page\n`);
  print_table(['decoder', 'ms', `times ${times[0].name}`], times.map(({ name, ms }) => [name, fixed(ms, 0), fixed(times[0].ms / ms, 2)]));
}

async function print_code() {
  console.log('### Code that a page loads\n');
  const total = (parts, bytes_of) => count(parts.reduce((sum, part) => sum + bytes_of(part), 0));
  print_table(['decoder', 'bytes', 'brotli'], (await code_of_pages(rivals)).map(([name, parts]) =>
    [name, total(parts, (part) => part.length), total(parts, (part) => brotliCompressSync(part).length)]));
}

const tables = { warm: print_warm, workers: print_workers, first: print_first, page: print_page, code: print_code };
for (const name of only.split(',')) await tables[name]();
