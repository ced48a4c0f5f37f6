// psplit/inline: the package in one file, also inside a page or a bundle, and what a page's policy must allow.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { page_test } from './browser.mjs';
import { compressed_primitives, modules_folder, package_folder, psplit, root } from './load.mjs';

const file = path.join(package_folder, 'inline.js');
const inline = await import(pathToFileURL(file));
const [{ bytes, attributes }] =
  compressed_primitives(path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb'), 'PSPLIT_mesh_draco_patches');
const expected = await psplit.decodeContainer(bytes, { attributes });
const argument = { container: Buffer.from(bytes).toString('base64'), attributes };

test('it exports what the package exports', () => assert.deepEqual(Object.keys(inline).sort(), Object.keys(psplit).sort()));

test('it decodes as the package', async () => {
  assert.deepEqual(await inline.decodeContainer(bytes, { attributes }), expected);
  const pool = inline.createPool({ workers: 2 });
  try {
    assert.deepEqual(await pool.decodeContainer(bytes, { attributes }), expected);
    await assert.rejects(pool.decodeContainer(bytes.subarray(1), { attributes }), { name: 'PsplitError', code: 'invalid-input' });
  } finally {
    pool.dispose();
  }
});

// Returns how each promise settles. `inline` is the module, or a bundle of it.
async function use({ container, attributes }) {
  const { createPool, decodeContainer, ready } = globalThis.psplit ?? await import('/psplit/inline.js');
  const { bytes_of_text, outcome } = await import('/page.js');
  const data = bytes_of_text(container), pool = createPool({ workers: 2 });
  const outcomes = [await outcome(ready()), await outcome(decodeContainer(data, { attributes })),
    await outcome(pool.decodeContainer(data, { attributes }))];
  pool.dispose();
  return outcomes;
}
const works = async ({ result, site }) => {
  assert.deepEqual(await result, ['done', 'done', 'done']);
  for (const request of site.requests) assert.ok(['/', '/main.js', '/page.js', '/psplit/inline.js', '/favicon.ico'].includes(request), request);
};
const policy = (value) => ({ 'Content-Security-Policy': value });

page_test('a page that loads one file', { argument, script: use }, works);
page_test('it works under a policy that allows blobs for workers, and no connections', {
  headers: policy("default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src blob:"), argument, script: use }, works);
page_test('under a policy without blobs, the calling thread decodes', {
  headers: policy("script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'"), argument, script: use, errors: [/worker-src/] },
async ({ result }) => assert.deepEqual(await result, ['done', 'done', 'done']));

// The page has the module in itself, and the main script waits for it.
const page_of = (script) => `<!doctype html><meta charset="utf-8"><title>test</title>
<script type="module">${script}</script><script type="module" src="/main.js"></script>`;
page_test('a page that has the module in itself', { argument, script: use,
  files: { '/': page_of(readFileSync(file, 'utf8').replace(/^export const (\{.*\}) = /m, 'globalThis.psplit = ')) } }, works);
for (const charset of ['ascii', 'utf8']) {
  const { outputFiles: [{ text }] } = await createRequire(path.join(modules_folder, 'package.json'))('esbuild').build({ bundle: true,
    minify: true, format: 'esm', charset, external: ['node:*'], write: false, logLevel: 'error', stdin: { contents: "globalThis.psplit = await import('./inline.js')",
      resolveDir: package_folder } });
  page_test(`a bundle by esbuild in ${charset}`, { argument, script: use, files: { '/': page_of(text) } }, works);
}
