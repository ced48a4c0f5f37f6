// The package: what npm would publish, what it exports, and how large it is.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, statSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { brotliCompressSync } from 'node:zlib';
import { modules_folder, package_folder, psplit } from './load.mjs';

test('npm packs these files', () => {
  const [{ files }] = JSON.parse(execFileSync('npm', ['pack', '--dry-run', '--json'], { cwd: package_folder, stdio: ['ignore', 'pipe', 'ignore'] }));
  assert.deepEqual(files.map((file) => file.path).sort(), [
    'LICENSE', 'README.md',
    'draco/conformance.md', 'draco/draco_decoder.wasm', 'draco/draco_wasm_wrapper.d.ts', 'draco/draco_wasm_wrapper.js', 'draco/package.json',
    'babylon.d.ts', 'babylon.js',
    'arriving.js', 'arriving_asset.js', 'container.js', 'container_job.js', 'error.js', 'files.js',
    'gltf-transform.d.ts', 'gltf-transform.js', 'gltf.js',
    'inline.d.ts', 'inline.js',
    'index.d.ts', 'index.js', 'instance.js', 'job.js', 'module.js', 'node.js', 'package.json', 'pool.js', 'psplit.wasm', 'task.js', 'types.js', 'worker.js',
    'three.d.ts', 'three.js',
    'three/aligned.js', 'three/container.js', 'three/draco_loader.js', 'three/growing_mesh.js', 'three/load_streaming.js', 'three/psplit_plugin.js',
  ].sort());
  assert.ok(statSync(path.join(package_folder, 'README.md')).size > 1000);
});

test('it exports what its types declare', () => {
  const declared = readFileSync(path.join(package_folder, 'index.d.ts'), 'utf8').matchAll(/^export (?:function|class) (\w+)/gm);
  assert.deepEqual(Object.keys(psplit).sort(), [...declared].map(([, name]) => name).sort());
});

// Limits a little above the sizes, so that growth is seen. The targets are 30 KB for the module that a page loads, and 4 KB for the
// code of plugin and pool.
const brotli = (contents) => brotliCompressSync(contents).length;
for (const [name, most] of [['psplit.wasm', 70000], ['draco/draco_decoder.wasm', 32600], ['draco/draco_wasm_wrapper.js', 6300], ['inline.js', 93000]])
  test(`the size of ${name}`, () => {
    const bytes = brotli(readFileSync(path.join(package_folder, name)));
    assert.ok(bytes < most, `${bytes} bytes in brotli`);
  });

// Code as pages have it: in one file, without comments, and without the loader's own code.
const { build } = createRequire(path.join(modules_folder, 'package.json'))('esbuild');
for (const [name, most] of [['index.js', 9050], ['worker.js', 4500], ['three.js', 9300], ['babylon.js', 6850], ['gltf-transform.js', 7800]])
  test(`the size of ${name} and what it imports, minified`, async () => {
    const { outputFiles: [{ contents }] } = await build({ entryPoints: [path.join(package_folder, name)], bundle: true, minify: true,
      format: 'esm', write: false, external: ['three', 'three/*', '@gltf-transform/core'], logLevel: 'error' });
    const bytes = brotli(contents);
    assert.ok(bytes < most, `${bytes} bytes in brotli`);
  });
