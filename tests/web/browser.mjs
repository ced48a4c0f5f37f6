// Opens pages in Chromium for tests. A site has files, headers and a script; the script runs in a page as its own module, so
// that the page's Content-Security-Policy holds for it:
//
//   page_test('what holds', { headers: { 'Content-Security-Policy': "..." },
//     script: async () => (await import('/psplit/index.js')).ready() },
//     async ({ result, page, site }) => assert.equal(await result, undefined));
//
// A test fails if the page or one of its workers reports an error that `errors` does not name. Without Chromium, tests are
// skipped, and say so. A test ends after kMostMs; Chromium ends with its pipe, also if this process is killed.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, readFileSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import path from 'node:path';
import test, { after, before } from 'node:test';
import { fileURLToPath } from 'node:url';
import { modules_folder, package_folder } from './load.mjs';

export const kMostMs = 60000;
// On a busy machine, Chromium itself needs about a minute to start. That is no part of a test.
const kMostMsToStart = 180000;

const chromium = ['chromium', 'chromium-browser', 'google-chrome']
  .map((name) => spawnSync('sh', ['-c', `command -v ${name}`], { encoding: 'utf8' }).stdout.trim())
  .find((found) => found) ?? null;
// The reason to skip tests, or false.
export const skip = chromium === null && 'there is no Chromium (Debian: chromium)';

let browser = null;

// Returns the Chromium of this process, which all tests share. The processor computes its WebGL and its WebGPU.
export async function open_browser() {
  const puppeteer = createRequire(path.join(modules_folder, 'package.json'))('puppeteer-core');
  // Chromium's sandbox does not work for root. Without Vulkan on SwiftShader, its GPU process ends at the first canvas of WebGPU.
  browser ??= puppeteer.launch({ executablePath: chromium, pipe: true, timeout: kMostMsToStart, protocolTimeout: kMostMsToStart, args: [
    ...(process.getuid?.() === 0 ? ['--no-sandbox'] : []), '--disable-dev-shm-usage', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader', '--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader', '--enable-features=Vulkan',
    '--use-vulkan=swiftshader', '--js-flags=--expose-gc'] });
  return browser;
}
// For programs that are not tests.
export const close_browser = async () => (await browser)?.close();
let has_browser = false;
// Starts Chromium before the tests of this file, and ends it after them.
export function need_browser() {
  if (has_browser || skip) return;
  has_browser = true;
  // Its first page takes longer than others.
  before(async () => (await (await open_browser()).newPage()).close(), { timeout: kMostMsToStart });
  after(close_browser, { timeout: kMostMs });
}

const kTypes = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css',
  '.json': 'application/json', '.wasm': 'application/wasm', '.gltf': 'model/gltf+json', '.glb': 'model/gltf-binary' };
const kPage = '<!doctype html><meta charset="utf-8"><title>test</title><script type="module" src="/main.js"></script>';

/**
 * Starts a server.
 * @param {object} [site]
 * @param {Object<string, string | Uint8Array | {folder: string} | null>} [site.files] by path: text, bytes, a folder (or a file)
 *   of this machine, or null: the server does not answer. By default the package is at /psplit/, npm's modules at /modules/, and
 *   page.js at /page.js.
 * @param {object | ((path: string) => object)} [site.headers] of every response
 * @param {object} [site.types] content types that differ, by extension; null for no type
 * @param {(argument: any) => Promise<*>} [site.script] the script /main.js of the page
 * @param {any} [site.argument] the script's argument, as JSON
 * @returns {Promise<{origin: string, requests: string[], close: () => void}>} close() returns at once
 */
export async function start_site({ files = {}, headers = {}, types = {}, script, argument } = {}) {
  const main = `globalThis.result = (${script ?? '() => {}'})(${JSON.stringify(argument) ?? ''});
    globalThis.result?.catch?.(() => {});  // the test has it`;
  const served = { '/': kPage, ...('/' in files && script === undefined ? {} : { '/main.js': main }),
    '/psplit/': { folder: package_folder }, '/modules/': { folder: path.join(modules_folder, 'node_modules') },
    '/page.js': { folder: fileURLToPath(new URL('page.js', import.meta.url)) }, '/favicon.ico': '', ...files };
  const content = (url) => {
    if (typeof served[url] === 'string' || served[url] instanceof Uint8Array) return served[url];
    const prefix = Object.keys(served).filter((name) => served[name]?.folder !== undefined && url.startsWith(name)).at(-1);
    const file = prefix && path.join(served[prefix].folder, url.slice(prefix.length), url.endsWith('/') ? 'index.html' : '');
    return file && existsSync(file) && statSync(file).isFile() ? readFileSync(file) : null;
  };
  const requests = [];
  const server = createServer((request, response) => {
    const url = decodeURIComponent(new URL(request.url, 'http://localhost').pathname), body = content(url);
    requests.push(url);
    if (served[url] === null) return;
    const extension = url.endsWith('/') ? '.html' : path.extname(url);
    const type = extension in types ? types[extension] : kTypes[extension] ?? 'application/octet-stream';
    response.writeHead(body === null ? 404 : 200, { ...(type === null ? {} : { 'Content-Type': type }),
      ...(typeof headers === 'function' ? headers(url) : headers) });
    response.end(body ?? '');
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve).unref());
  return { origin: `http://127.0.0.1:${server.address().port}`, requests,
    close: () => server.close() && server.closeAllConnections() };
}

/**
 * Opens a page in a profile of its own.
 * @returns {Promise<{page: import('puppeteer-core').Page, errors: string[], close: () => Promise<void>}>} `errors` are those
 *   that the page and its workers report: exceptions, console errors, violations of the policy, failed requests.
 */
export async function open_page(url) {
  const context = await (await open_browser()).createBrowserContext();
  const page = await context.newPage(), errors = [];
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('requestfailed', (request) => errors.push(`${request.url()}: ${request.failure()?.errorText}`));
  page.on('error', (error) => errors.push(`crash: ${error.message}`));
  const log = await page.createCDPSession();
  // Puppeteer does not report the log entries of workers.
  log.on('Log.entryAdded', ({ entry }) => entry.level === 'error' && entry.source === 'worker' && errors.push(entry.text));
  await log.send('Log.enable');
  await page.goto(url, { timeout: kMostMs });
  return { page, errors, close: () => context.close() };
}

/**
 * Adds a test, which has a site and a page of its own. start_site gets the options, too.
 * @param {string} name
 * @param {object} options
 * @param {RegExp[]} [options.errors] the errors that the page reports: each of these, and no others
 * @param {string | false} [options.skip] the reason why the test does not run
 * @param {number} [options.timeout] in milliseconds; by default kMostMs
 * @param {(of: {result: Promise<*>, page: object, site: object, errors: string[]}) => Promise<void>} check
 *   `result` is the script's promise
 */
export function page_test(name, { errors: expected = [], skip: why = false, timeout = kMostMs, ...options }, check) {
  need_browser();
  test(name, { skip: skip || why, timeout }, async () => {
    const site = await start_site(options);
    let opened;
    try {
      opened = await open_page(site.origin);
      const { page, errors } = opened;
      const result = page.evaluate(() => globalThis.result);
      result.catch(() => {});  // `check` awaits it later
      await check({ result, page, site, errors });
      // On a busy machine, errors may arrive after the result.
      const is_missing = () => expected.some((pattern) => !errors.some((error) => pattern.test(error)));
      for (const end = Date.now() + 10_000; is_missing() && Date.now() < end;) await new Promise((done) => setTimeout(done, 50));
      assert.deepEqual(errors.filter((error) => !expected.some((pattern) => pattern.test(error))), []);
      for (const pattern of expected)
        assert.ok(errors.some((error) => pattern.test(error)), `${pattern} does not occur: ${errors}`);
    } finally {
      await opened?.close();
      site.close();
    }
  });
}
