// Every promise settles under all policies, isolation, content types, missing files and other origins.
import assert from 'node:assert/strict';
import path from 'node:path';
import { page_test, start_site } from './browser.mjs';
import { compressed_primitives, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const [[, stream]] = [...streams()];
const [{ bytes, attributes }] =
  compressed_primitives(path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb'), 'PSPLIT_mesh_draco_patches');
const text = (data) => Buffer.from(data).toString('base64');
const argument = { stream: text(stream), container: text(bytes), attributes };

// Does everything that a page does with the package at `from`. Returns how each promise settles.
async function use_all({ stream, container, attributes, from = '/psplit/index.js' }) {
  const { createPool, decodeContainer, decodeDraco, ready } = await import(from);
  const { bytes_of_text, outcome } = await import('/page.js');
  const pool = createPool({ workers: 2, mainThread: false }), other = createPool({ workers: 2 }), [draco, patches] = [bytes_of_text(stream), bytes_of_text(container)];
  const outcomes = {
    ready: await outcome(ready()), stream: await outcome(decodeDraco(draco)),
    container: await outcome(decodeContainer(patches, { attributes })), pool: await outcome(pool.ready()),
    pool_stream: await outcome(pool.decodeDraco(draco)),
    pool_container: await outcome(pool.decodeContainer(patches, { attributes })),
    other_container: await outcome(other.decodeContainer(patches, { attributes })),
  };
  pool.dispose();
  other.dispose();
  return { outcomes, isolated: globalThis.crossOriginIsolated };
}

const done = { ready: 'done', stream: 'done', container: 'done', pool: 'done', pool_stream: 'done', pool_container: 'done', other_container: 'done' };
const works = (isolated) => async ({ result }) => assert.deepEqual(await result, { outcomes: done, isolated });
// Checks that all outcomes, except those named in `but`, are failures with a message.
const fails = (message, but = []) => async ({ result }) => {
  for (const [name, outcome] of Object.entries((await result).outcomes)) {
    if (but.includes(name)) assert.equal(outcome, 'done', name);
    else {
      assert.deepEqual([outcome.name, outcome.code], ['PsplitError', 'failed'], `${name}: ${JSON.stringify(outcome)}`);
      assert.match(outcome.message, message, name);
    }
  }
};
// What works if no worker can be started: a pool's own thread decodes, if it may.
const not_pool = ['ready', 'stream', 'container', 'pool', 'other_container'];
const kNoWorker = /^worker: http:.*\/psplit\/worker\.js cannot be loaded$/;
const policy = (value) => ({ 'Content-Security-Policy': value });
const isolation = { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' };

const kEnough = "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'";
const kStrict = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; " +
  "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
for (const [name, headers, isolated] of [['no policy', {}, false], ['a policy', policy(kEnough), false],
  ['a strict policy', policy(kStrict), false], ['isolation', isolation, true],
  ['a policy and isolation', { ...policy(kEnough), ...isolation }, true]])
  page_test(`it works under ${name}`, { headers, argument, script: use_all }, works(isolated));

page_test('a policy without wasm-unsafe-eval', { headers: policy("script-src 'self'; worker-src 'self'"), argument,
  script: use_all }, fails(/^http:.*\/psplit\/psplit\.wasm cannot be loaded: WebAssembly.*Content Security policy/));
page_test('a policy without workers', { headers: policy("script-src 'self' 'wasm-unsafe-eval'; worker-src 'none'"), argument,
  script: use_all, errors: [/worker-src/] }, fails(kNoWorker, not_pool));
page_test('a policy without connections', { headers: policy(`${kEnough}; connect-src 'none'`), argument, script: use_all,
  errors: [/Content Security Policy/] }, fails(/^http:.*\/psplit\/psplit\.wasm cannot be loaded: Failed to fetch$/));
page_test('trusted types', { headers: policy(`${kEnough}; require-trusted-types-for 'script'`), argument, script: use_all,
  errors: [/TrustedScriptURL/] }, fails(/^worker: .*TrustedScriptURL/, not_pool));
page_test('trusted types with a policy of the page', {
  headers: policy(`${kEnough}; require-trusted-types-for 'script'; trusted-types default`),
  files: { '/': '<!doctype html><script type="module" src="/trust.js"></script><script type="module" src="/main.js"></script>',
    '/trust.js': `trustedTypes.createPolicy('default', { createScriptURL: (url) => {
      if (new URL(url).pathname !== '/psplit/worker.js') throw new TypeError(url);
      return url;
    } });` },
  argument, script: use_all }, works(false));
// The page compiles the module and posts it, so the worker needs no permission.
page_test('a policy of worker.js alone, without wasm-unsafe-eval', {
  headers: (file) => (file === '/psplit/worker.js' ? policy("script-src 'self'") : {}), argument, script: use_all },
works(false));

for (const type of ['application/octet-stream', 'text/plain', null])
  page_test(`psplit.wasm of the type ${type}`, { types: { '.wasm': type }, argument, script: use_all }, works(false));
page_test('psplit.wasm is a page', { files: { '/psplit/psplit.wasm': '<!doctype html>' }, argument, script: use_all },
  fails(/^http:.*\/psplit\/psplit\.wasm cannot be loaded: the server sent something else than WebAssembly$/));
page_test('no psplit.wasm', { files: { '/psplit/psplit.wasm': { folder: '/nowhere' } }, argument, script: use_all,
  errors: [/psplit\.wasm: net::ERR_ABORTED|404/] }, fails(/^http:.*\/psplit\/psplit\.wasm cannot be loaded: HTTP status 404$/));
page_test('no worker.js', { files: { '/psplit/worker.js': { folder: '/nowhere' } }, argument, script: use_all,
  errors: [/worker\.js: net::ERR_FAILED|404/] }, fails(kNoWorker, not_pool));
page_test('worker.js is a page', {
  headers: (file) => (file === '/psplit/worker.js' ? { 'Content-Type': 'text/html' } : {}), argument,
  script: use_all, errors: [/MIME type/] }, fails(kNoWorker, not_pool));
for (const file of ['worker.js', 'psplit.wasm'])
  page_test(`the server does not answer for ${file}`, { files: { [`/psplit/${file}`]: null }, argument, script: async (of) => {
    const { createPool } = await import('/psplit/index.js'), { bytes_of_text, outcome } = await import('/page.js');
    const pool = createPool({ workers: 1 }), controller = new AbortController(), { signal } = controller;
    const stream = bytes_of_text(of.stream);
    const jobs = [pool.decodeDraco(stream, { signal }), pool.decodeDraco(stream)].map(outcome);
    setTimeout(() => controller.abort(), 100);
    await jobs[0];
    pool.dispose();
    return (await Promise.all(jobs)).map(({ code }) => code);
  } }, async ({ result }) => assert.deepEqual(await result, ['aborted', 'aborted']));
page_test('a worker that throws', { files: { '/psplit/worker.js': 'throw new Error("broken")' }, argument, script: use_all },
  fails(/^worker: .*broken$/, not_pool));

// psplit/inline has its worker in a blob.
const inline = { ...argument, from: '/psplit/inline.js' };
page_test('psplit/inline under a policy that allows blobs', { argument: inline, script: use_all,
  headers: policy("script-src 'self' 'wasm-unsafe-eval'; worker-src blob:; connect-src 'none'") }, works(false));
page_test('psplit/inline under a policy without blobs', { headers: policy(kEnough), argument: inline, script: use_all,
  errors: [/worker-src/] }, fails(/^worker: blob:http:.* cannot be loaded$/, not_pool));

// The package comes from another origin, which is a second site.
for (const [name, file, headers, check, errors] of [
  ['the package on another origin that allows it', 'index.js', { 'Access-Control-Allow-Origin': '*' },
    fails(/^worker: .*cannot be accessed from origin/, not_pool), []],
  ['psplit/inline on another origin', 'inline.js', { 'Access-Control-Allow-Origin': '*' }, works(false), []],
  ['the package on another origin that does not allow it', 'index.js', {},
    ({ result }) => assert.rejects(result, /Failed to fetch dynamically imported module/), [/CORS|ERR_FAILED/]]])
  page_test(name, { errors }, async ({ page, ...of }) => {
    const other = await start_site({ headers });
    try {
      await check({ ...of, page, result: page.evaluate(use_all, { ...argument, from: `${other.origin}/psplit/${file}` }) });
    } finally {
      other.close();
    }
  });
