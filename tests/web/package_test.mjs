// The package: what npm would publish, what it exports, and how large it is.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, statSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { brotliCompressSync } from 'node:zlib';
import { package_folder, psplit } from './load.mjs';

test('npm packs these files', () => {
  const [{ files }] = JSON.parse(execFileSync('npm', ['pack', '--dry-run', '--json'], { cwd: package_folder, stdio: ['ignore', 'pipe', 'ignore'] }));
  assert.deepEqual(files.map((file) => file.path).sort(), [
    'LICENSE', 'README.md',
    'draco/conformance.md', 'draco/draco_decoder.wasm', 'draco/draco_wasm_wrapper.d.ts', 'draco/draco_wasm_wrapper.js', 'draco/package.json',
    'babylon.d.ts', 'babylon.js',
    'container.js', 'container_job.js', 'error.js', 'files.js',
    'gltf-transform.d.ts', 'gltf-transform.js', 'gltf.js',
    'inline.d.ts', 'inline.js',
    'index.d.ts', 'index.js', 'instance.js', 'job.js', 'module.js', 'node.js', 'package.json', 'pool.js', 'psplit.wasm', 'task.js', 'types.js', 'worker.js',
    'three.d.ts', 'three.js',
    'three/aligned.js', 'three/container.js', 'three/draco_loader.js', 'three/growing_mesh.js', 'three/psplit_plugin.js',
  ].sort());
  assert.ok(statSync(path.join(package_folder, 'README.md')).size > 1000);
});

test('it exports what its types declare', () => {
  const declared = readFileSync(path.join(package_folder, 'index.d.ts'), 'utf8').matchAll(/^export (?:function|class) (\w+)/gm);
  assert.deepEqual(Object.keys(psplit).sort(), [...declared].map(([, name]) => name).sort());
});

// Limits, so that growth is seen.
for (const [name, most] of [['psplit.wasm', 66000], ['draco/draco_decoder.wasm', 31000], ['draco/draco_wasm_wrapper.js', 6300]])
  test(`the size of ${name}`, () => {
    const bytes = brotliCompressSync(readFileSync(path.join(package_folder, name))).length;
    assert.ok(bytes < most, `${bytes} bytes in brotli`);
  });
