// vite, webpack and esbuild build bindings/web/examples/bundlers, and Chromium shows it. Imports work where there is no page.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { open_page, page_test, skip } from './browser.mjs';
import { modules_folder, package_folder, root } from './load.mjs';

// The example is copied to a folder below the bundlers' packages, and the package is installed in it.
const folder = path.join(root, 'build/web/bundlers');
rmSync(folder, { recursive: true, force: true });
cpSync(path.join(root, 'bindings/web/examples/bundlers'), folder, { recursive: true });
cpSync(package_folder, path.join(folder, 'node_modules/psplit'), { recursive: true });
const bin = path.join(modules_folder, 'node_modules/.bin');

const shown = ['Draco stream: 1826 faces, 991 points', 'Container: 1222 faces, 663 points', 'Encoded anew: 1826 faces, 991 points'];
// Returns the text of the example's page when it is done.
const text_of = async (page) => {
  await page.waitForSelector('[data-done]', { timeout: 30000 });
  return page.$$eval('figure', (figures) => figures.map(({ textContent }) => textContent));
};

for (const bundler of ['vite', 'webpack', 'esbuild']) {
  test(`${bundler} builds the example`, { timeout: 60000 }, () => {
    const env = { ...process.env, PATH: `${bin}:${process.env.PATH}` };
    execFileSync('npm', ['run', '--silent', bundler], { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'], env });
  });
  page_test(`the page that ${bundler} built`, { files: { '/': { folder: path.join(folder, 'dist', bundler) } },
    headers: { 'Content-Security-Policy': "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'" } }, async ({ page }) => {
    assert.deepEqual(await text_of(page), shown);
  });
}

test("vite's development server", { skip, timeout: 60000 }, async () => {
  const { createServer } = await import(pathToFileURL(createRequire(path.join(modules_folder, 'package.json')).resolve('vite')));
  const server = await createServer({ root: folder, logLevel: 'error', server: { host: '127.0.0.1', port: 0, hmr: false } });
  await server.listen();
  let opened;
  try {
    opened = await open_page(server.resolvedUrls.local[0]);
    assert.deepEqual(await text_of(opened.page), shown);
    assert.deepEqual(opened.errors, []);
  } finally {
    await opened?.close();
    await server.close();
  }
});

test("the example's bundlers are those of the tests", () => {
  const read = (file) => JSON.parse(readFileSync(path.join(root, file)));
  const { devDependencies } = read('bindings/web/examples/bundlers/package.json'), { dependencies } = read('tests/web/package.json');
  for (const [name, version] of Object.entries(devDependencies)) assert.equal(dependencies[name], version, name);
});

// Servers import pages' code when they render pages. Nothing may happen then.
const { exports: entries } = JSON.parse(readFileSync(path.join(package_folder, 'package.json')));
const modules = Object.values(entries).map((entry) => entry.default)
  .filter((file) => file?.endsWith('.js') && !file.startsWith('./draco/'));
test('importing has no effects in Node.js', () => {
  const source = `delete globalThis.navigator;
    const before = Object.keys(globalThis).length;
    for (const url of process.argv.slice(1)) await import(url);
    if (Object.keys(globalThis).length !== before) throw new Error('a global variable');`;
  const urls = modules.map((file) => pathToFileURL(path.join(package_folder, file)).href);
  assert.ok(urls.length >= 3);
  const printed = execFileSync(process.execPath, ['--input-type=module', '-e', source, ...urls],
    { encoding: 'utf8', timeout: 30000 });
  assert.equal(printed, '');
});

page_test('in a worker of the page, which may have workers too', {
  files: { '/job.js': `import { createPool, decodeDraco } from '/psplit/index.js';
    const bytes = await (await fetch('/stream.drc')).arrayBuffer(), pool = createPool({ workers: 2 });
    postMessage([(await decodeDraco(bytes)).faceCount, (await pool.decodeDraco(bytes)).faceCount]);
    pool.dispose();`, '/stream.drc': readFileSync(path.join(folder, 'stream.drc')) },
  script: () => new Promise((resolve, reject) => {
    const worker = new Worker('/job.js', { type: 'module' });
    worker.onmessage = ({ data }) => resolve(data);
    worker.onerror = ({ message }) => reject(new Error(message));
  }),
}, async ({ result }) => assert.deepEqual(await result, [1826, 1826]));
