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
  assert.deepEqual(files.map((file) => file.path).sort(), ['LICENSE', 'README.md', 'error.js', 'index.d.ts', 'index.js',
    'instance.js', 'job.js', 'module.js', 'package.json', 'pool.js', 'psplit.wasm', 'worker.js']);
  assert.ok(statSync(path.join(package_folder, 'README.md')).size > 1000);
});

test('it exports what its types declare', () => {
  const declared = readFileSync(path.join(package_folder, 'index.d.ts'), 'utf8').matchAll(/^export (?:function|class) (\w+)/gm);
  assert.deepEqual(Object.keys(psplit).sort(), [...declared].map(([, name]) => name).sort());
});

test('the size of the module', () => {
  const bytes = brotliCompressSync(readFileSync(path.join(package_folder, 'psplit.wasm'))).length;
  assert.ok(bytes < 90000, `${bytes} bytes in brotli`);
});
