// The containers that gltf-psplit makes of the corpus, decoded on a GPU and compared with WebAssembly's results: by Dawn in Node.js, in
// Chromium, and by wgpu in Deno. A program:  node tests/web/webgpu_corpus.mjs [--some] [--condense] [--dawn | --chromium | --deno]
//
// --some takes few and small ones, --condense only condensed ones. Without a GPU, the processor runs the shaders: VK_DRIVER_FILES names another driver.
import { spawnSync } from 'node:child_process';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { close_browser, open_page, skip as no_browser, start_site } from './browser.mjs';
import { compressed_primitives, corpus_folder, files_below, gltf_psplit, psplit, root } from './load.mjs';
import { add, compare } from './webgpu_compare.js';
import { no_deno, run_in_deno } from './webgpu_compilers.mjs';
import { createGpuDecoder, request_device, skip as no_gpu } from './webgpu_device.mjs';

const folder = path.join(root, 'build/web/gpu');
const kKinds = { default: ['--always-patches'], 440: ['--patch-faces', '440'], 1200: ['--patch-faces', '1200'],
  slow: ['--always-patches', '--encode-speed', '3'] };
const kCondensed = Object.fromEntries(Object.entries(kKinds).map(([kind, options]) => [`condensed ${kind}`, [...options, '--condense']]));
// Exit codes of gltf-psplit.
const kMalformed = 3, kUnsupported = 5;
const kBatchBytes = 30000, kFewBytes = 8000, kEach = 8;

/** The reason why there is nothing to compare, or false. */
export const skip = (corpus_folder === null && 'there is no corpus') || (gltf_psplit === null && 'there is no gltf-psplit');

/** The containers in batches: { name, bytes, attributes } each. Of condensed ones, a few are those of one kind. */
export function make_batches(some, condense = false) {
  const { 'condensed default': condensed } = kCondensed, kinds = condense ? kCondensed : some ? { ...kKinds, condensed } : kKinds;
  const batches = [[]];
  for (const [kind, options] of Object.entries(kinds)) {
    const gltf = path.join(corpus_folder, 'gltf'), out = path.join(folder, kind);
    rmSync(out, { recursive: true, force: true });
    const { status, stderr, error } = spawnSync(gltf_psplit, ['batch', '-q', '-o', out, '--base', gltf, '--images', 'reference', ...options, path.join(gltf, '**/*.glb'), path.join(gltf, '**/*.gltf')], { encoding: 'utf8', maxBuffer: 1 << 28 });
    // Some assets of the corpus are malformed, or of kinds that are not encoded: the first of them gives the code.
    if (error !== undefined || ![0, kMalformed, kUnsupported].includes(status)) throw error ?? new Error(`gltf-psplit batch, ${kind}: exit code ${status}\n${stderr}`);
    const before = batches.flat().length;
    let count = 0, bytes_of_batch = 0;
    for (const file of files_below(out, /\.(glb|gltf)$/))
      for (const [i, { bytes, attributes }] of compressed_primitives(file, 'PSPLIT_mesh_draco_patches').entries()) {
        if (some && (count++ % kEach !== 0 || bytes.length > kFewBytes)) continue;
        if ((bytes_of_batch += bytes.length) > kBatchBytes && batches.at(-1).length > 0) batches.push([]), (bytes_of_batch = bytes.length);
        batches.at(-1).push({ name: `${kind}/${path.relative(out, file)}, primitive ${i}`, bytes: bytes.slice(), attributes });
      }
    if (batches.flat().length === before) throw new Error(`${kind}: no containers`);
  }
  return batches;
}

/** Decodes batches in Node.js. */
export async function compare_in_dawn(batches) {
  const device = await request_device(), decoder = await createGpuDecoder(device), sum = {};
  for (const batch of batches) add(sum, await compare(decoder, psplit.decodeContainer, batch));
  device.destroy();
  return sum;
}

/** Decodes batches in Chromium. */
export async function compare_in_chromium(batches) {
  const files = { '/compare.js': { folder: fileURLToPath(new URL('webgpu_compare.js', import.meta.url)) } };
  batches.forEach((batch, b) => batch.forEach(({ bytes }, i) => (files[`/${b}/${i}.bin`] = bytes)));
  const site = await start_site({ files, script: async () => {
    const { createGpuDecoder } = await import('/psplit/webgpu.js'), { decodeContainer } = await import('/psplit/index.js'), { compare } = await import('/compare.js');
    const device = await (await navigator.gpu.requestAdapter()).requestDevice(), decoder = await createGpuDecoder(device);
    globalThis.compare_batch = async (b, batch) => compare(decoder, decodeContainer, await Promise.all(batch.map(async (container, i) =>
      ({ ...container, bytes: new Uint8Array(await (await fetch(`/${b}/${i}.bin`)).arrayBuffer()) }))));
  } });
  const { page, errors, close } = await open_page(site.origin), sum = {};
  try {
    await page.evaluate(() => globalThis.result);
    for (const [b, batch] of batches.entries())
      add(sum, await page.evaluate((number, containers) => globalThis.compare_batch(number, containers), b, batch.map(({ name, attributes }) => ({ name, attributes }))));
    if (errors.length > 0) throw new Error(errors.join('\n'));
  } finally {
    await close();
    site.close();
  }
  return sum;
}

/** Decodes batches in Deno. */
export async function compare_in_deno(batches) {
  const of_deno = path.join(folder, 'deno');
  rmSync(of_deno, { recursive: true, force: true });
  mkdirSync(of_deno, { recursive: true });
  const list = batches.map((batch, b) => batch.map(({ name, attributes, bytes }, i) => {
    const file = `${b}-${i}.bin`;
    writeFileSync(path.join(of_deno, file), bytes);
    return { name, attributes, file };
  }));
  writeFileSync(path.join(of_deno, 'batches.json'), JSON.stringify(list));
  const [{ adapter, messages }, sum] = run_in_deno(of_deno);
  if (sum === undefined) throw new Error(`Deno, ${adapter}: ${messages}`);
  return sum;
}

export const summary = ({ equal, by_wasm, refused, differences }) =>
  `${equal} containers equal, ${by_wasm} by WASM${refused > 0 ? `, ${refused} refused` : ''}${differences.length > 0 ? `, ${differences.length} DIFFERENT` : ''}`;

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const options = process.argv.slice(2), is_wanted = (way) => options.includes(`--${way}`) || !options.some((option) => /^--(dawn|chromium|deno)$/.test(option));
  const why = skip || (is_wanted('dawn') && no_gpu) || (is_wanted('chromium') && no_browser) || (options.includes('--deno') && no_deno);
  if (why) {
    console.error(`web-gpu: ${why}`);
    process.exit(1);
  }
  const batches = make_batches(options.includes('--some'), options.includes('--condense'));
  console.log(`${batches.flat().length} containers`);
  let has_failed = false;
  for (const [way, run] of Object.entries({ dawn: compare_in_dawn, chromium: compare_in_chromium, deno: compare_in_deno })) {
    if (!is_wanted(way) || (way === 'deno' && no_deno)) continue;
    const sum = await run(batches);
    for (const line of [...sum.differences, ...sum.reasons]) console.log(`  ${line}`);
    console.log(`${way}: ${summary(sum)}`);
    has_failed ||= sum.differences.length > 0;
  }
  await close_browser();
  process.exit(has_failed ? 1 : 0);
}
