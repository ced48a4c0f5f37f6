// The README's component for React: esbuild builds a page of it, which Chromium shows, and webpack builds it for a server, as
// Next.js does, where it renders without a page.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { promisify } from 'node:util';
import { page_test } from './browser.mjs';
import { link_package, modules_folder, package_folder, readme_blocks, root } from './load.mjs';
import { draco_glb, streams } from './stock_draco.mjs';

link_package();
const require_module = createRequire(path.join(modules_folder, 'package.json'));
const { build, transform } = require_module('esbuild');
const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb'), [[, stream]] = [...streams()];

// Below the modules, so that imports find them.
const folder = path.join(modules_folder, 'react');
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const [component] = readme_blocks()['React'];
writeFileSync(path.join(folder, 'model.tsx'), component);
const [, set_path] = readFileSync(path.join(root, 'bindings/web/README.md'), 'utf8').match(/`(useGLTF\.setDecoderPath\(.*?\))`/);
writeFileSync(path.join(folder, 'draco_model.tsx'), `import { useGLTF } from '@react-three/drei';
  ${set_path};
  export const DracoModel = ({ url }) => <primitive object={useGLTF(url).scene} />;`);
const page = `import { Canvas } from '@react-three/fiber';
  import { Suspense } from 'react';
  export const Page = ({ Model, urls, onScene }) => <Canvas onCreated={({ scene }) => onScene?.(scene)}>
    {urls.map((url) => <Suspense key={url}><Model url={url} /></Suspense>)}
  </Canvas>;`;
writeFileSync(path.join(folder, 'page.tsx'), page);
// The result has the numbers of faces when all models are there.
writeFileSync(path.join(folder, 'main.tsx'), `import { createRoot } from 'react-dom/client';
  import { DracoModel } from './draco_model';
  import { Model } from './model';
  import { Page } from './page';
  const draco_only = location.search === '?draco';
  const urls = draco_only ? ['/draco.glb'] : ['/patches.glb', '/draco.glb'];
  const counts_of = (scene) => new Promise((resolve) => {
    const timer = setInterval(() => {
      const counts = [];
      scene.traverse((object) => object.isMesh && counts.push(object.geometry.index.count / 3));
      if (counts.length < urls.length) return;
      clearInterval(timer);
      resolve(counts.sort((a, b) => a - b));
    }, 20);
  });
  globalThis.result = new Promise((resolve) => {
    const props = { Model: draco_only ? DracoModel : Model, urls, onScene: (scene) => resolve(counts_of(scene)) };
    createRoot(document.getElementById('root')).render(<Page {...props} />);
  });`);

const dist = path.join(folder, 'dist');
await build({ entryPoints: { main: path.join(folder, 'main.tsx'), worker: path.join(package_folder, 'worker.js') },
  bundle: true, format: 'esm', outdir: dist, jsx: 'automatic', define: { 'process.env.NODE_ENV': '"production"' },
  logLevel: 'error' });
copyFileSync(path.join(package_folder, 'psplit.wasm'), path.join(dist, 'psplit.wasm'));
const files = {
  '/': `<!doctype html><div id="root" style="height: 200px"></div><script type="module" src="/dist/main.js"></script>`,
  '/dist/': { folder: dist }, '/patches.glb': { folder: sample }, '/draco.glb': draco_glb(stream) };
page_test('useGLTF loads patches and Draco', { files }, async ({ result, page, site }) => {
  assert.deepEqual(await result, [1222, 1826]);
  assert.ok(site.requests.includes('/dist/worker.js'), `${site.requests}`);
  assert.ok(!site.requests.some((url) => url.startsWith('/psplit/draco/')));
  await page.goto(`${site.origin}/?draco`);
  assert.deepEqual(await page.evaluate(() => globalThis.result), [1826]);
  assert.ok(site.requests.includes('/psplit/draco/draco_decoder.wasm'));
});

// webpack has no TypeScript, so esbuild translates each file before.
test('a server renders the page', { timeout: 60000 }, async () => {
  const modules = { model: component, page, server: `import { renderToString } from 'react-dom/server';
    import { Model } from './model';
    import { Page } from './page';
    console.log(renderToString(<Page Model={Model} urls={['/patches.glb']} />));` };
  const source = path.join(folder, 'server'), webpack = require_module('webpack');
  mkdirSync(source);
  for (const [name, text] of Object.entries(modules)) {
    const { code } = await transform(text, { loader: 'tsx', jsx: 'automatic' });
    writeFileSync(path.join(source, `${name}.js`), code);
  }
  // As Next.js sets webpack for servers.
  const stats = await promisify(webpack)({ mode: 'none', target: 'node18', entry: path.join(source, 'server.js'),
    module: { parser: { javascript: { url: 'relative' } }, rules: [{ test: /\.js$/, resolve: { fullySpecified: false } }] },
    output: { path: path.join(dist, 'server'), filename: 'server.cjs', publicPath: '/_next/', libraryTarget: 'commonjs2' } });
  assert.deepEqual(stats.toJson({ all: false, errors: true }).errors.map(({ message }) => message), []);
  const html = execFileSync(process.execPath, [path.join(dist, 'server/server.cjs')], { encoding: 'utf8', timeout: 30000 });
  assert.match(html, /<canvas/);
});
