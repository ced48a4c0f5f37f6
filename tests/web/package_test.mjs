// The package: what npm would publish, what it exports, and how large it is.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, statSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { brotliCompressSync } from 'node:zlib';
import { modules_folder, package_folder, psplit } from './load.mjs';
import { code_of_page } from './page_code.mjs';

test('npm packs these files', () => {
  const [{ files }] = JSON.parse(execFileSync('npm', ['pack', '--dry-run', '--json'], { cwd: package_folder, stdio: ['ignore', 'pipe', 'ignore'] }));
  assert.deepEqual(files.map((file) => file.path).sort(), [
    'LICENSE', 'README.md', 'docs/web.md', 'docs/webgpu.md',
    'draco/conformance.md', 'draco/draco_decoder.wasm', 'draco/draco_wasm_wrapper.d.ts', 'draco/draco_wasm_wrapper.js', 'draco/package.json',
    'draco/draco_encoder.d.ts', 'draco/draco_encoder.js', 'draco/draco_encoder.wasm', 'draco/encoder.md',
    'asset.d.ts', 'asset.js', 'babylon.d.ts', 'babylon.js', 'babylon/gpu_buffers.js',
    'arriving.js', 'arriving_asset.js', 'choice.js', 'compile.js', 'container.js', 'container_job.js', 'error.js', 'files.js',
    'encode.d.ts', 'encode.js', 'encode_files.js', 'encode_job.js', 'encode_runner.js', 'encode_worker.js', 'psplit_encoder.wasm', 'worker_port.js', 'workers.js',
    'gltf-transform.d.ts', 'gltf-transform.js', 'gltf.js', 'head.js', 'aligned.js', 'growing_mesh.js',
    'inline.d.ts', 'inline.js',
    'index.d.ts', 'index.js', 'instance.js', 'job.js', 'job_runner.js', 'module.js', 'node.js', 'package.json', 'part.js', 'pool.js', 'psplit.wasm', 'psplit_condensed.wasm', 'task.js', 'types.js', 'wasm.d.ts', 'worker.js',
    'three.d.ts', 'three.js',
    'webgpu.d.ts', 'webgpu.js',
    'webgpu/attributes.wgsl.js', 'webgpu/batch.js', 'webgpu/batched_decoder.js', 'webgpu/bit_string.js', 'webgpu/border_part.wgsl.js', 'webgpu/border_walk.wgsl.js',
    'webgpu/condensed.js', 'webgpu/condensed_attributes.wgsl.js', 'webgpu/condensed_connectivity.wgsl.js', 'webgpu/condensed_head.js', 'webgpu/condensed_layout.js', 'webgpu/condensed_stream.js',
    'webgpu/connectivity.wgsl.js', 'webgpu/container_plan.js', 'webgpu/creation.wgsl.js', 'webgpu/directory.js', 'webgpu/edgebreaker_symbols.wgsl.js', 'webgpu/floats.wgsl.js',
    'webgpu/integers.wgsl.js', 'webgpu/layout.js', 'webgpu/multi_parallelogram.wgsl.js', 'webgpu/normals.wgsl.js',
    'webgpu/octahedral.wgsl.js', 'webgpu/platform.wgsl.js', 'webgpu/prediction.wgsl.js', 'webgpu/rans.wgsl.js', 'webgpu/refusal.js',
    'webgpu/seams.wgsl.js', 'webgpu/section.wgsl.js', 'webgpu/shaders.js', 'webgpu/stitch.wgsl.js', 'webgpu/stitch_map.wgsl.js', 'webgpu/stream_head.js',
    'webgpu/symbols.wgsl.js', 'webgpu/tex_coords.wgsl.js', 'webgpu/traversal.wgsl.js', 'webgpu/value_writer.wgsl.js',
    'three/container.js', 'three/draco_loader.js', 'three/gpu_attributes.js', 'three/load_streaming.js', 'three/psplit_plugin.js', 'three/stock_draco.js',
  ].sort());
  assert.ok(statSync(path.join(package_folder, 'README.md')).size > 1000);
  for (const { path: file, mode } of files) assert.equal(mode, 0o644, file);
});

test('links work from the package', () => {
  let count = 0;
  for (const page of ['README.md', 'docs/web.md', 'docs/webgpu.md', 'draco/conformance.md', 'draco/encoder.md']) {
    const text = readFileSync(path.join(package_folder, page), 'utf8');
    const anchors = [...text.matchAll(/^#+ (.*)$/gm)].map(([, heading]) => heading.toLowerCase().replace(/[^\w -]/g, '').replaceAll(' ', '-'));
    for (const [, link] of text.matchAll(/\]\(([^)]*)\)/g)) {
      ++count;
      if (link.startsWith('#')) assert.ok(anchors.includes(link.slice(1)), `${page}: ${link}`);
      else if (!link.startsWith('https://')) assert.ok(statSync(path.join(package_folder, path.dirname(page), link)).isFile(), `${page}: ${link}`);
    }
  }
  assert.ok(count > 10);
});

test('package.json says what npm shows', () => {
  const { license, keywords, description, repository, homepage, bugs, peerDependencies, peerDependenciesMeta } = JSON.parse(readFileSync(path.join(package_folder, 'package.json')));
  assert.equal(license, 'Apache-2.0');
  assert.match(readFileSync(path.join(package_folder, 'LICENSE'), 'utf8'), /Apache License\s+Version 2\.0/);
  for (const word of ['draco', 'gltf', 'three', 'wasm']) assert.ok(keywords.includes(word), word);
  assert.ok(description.length > 20);
  for (const address of [repository.url, homepage, bugs]) assert.match(address, /^(git\+)?https:/);
  assert.equal(repository.directory, 'bindings/web');
  for (const name of ['three', '@babylonjs/core', '@babylonjs/loaders', '@gltf-transform/core'])
    assert.ok(name in peerDependencies && peerDependenciesMeta[name].optional, name);
});

test('it exports what its types declare', () => {
  const declared = readFileSync(path.join(package_folder, 'index.d.ts'), 'utf8').matchAll(/^export (?:function|class) (\w+)/gm);
  assert.deepEqual(Object.keys(psplit).sort(), [...declared].map(([, name]) => name).sort());
});

// Limits a little above the sizes, so that growth is seen. docs/web.md has the targets. Of webgpu.js, index.js has 1.1 KB as well.
const brotli = (contents) => brotliCompressSync(contents).length;
for (const [name, most] of [['psplit.wasm', 49200], ['psplit_condensed.wasm', 72600], ['psplit_encoder.wasm', 202500], ['draco/draco_decoder.wasm', 34400], ['draco/draco_wasm_wrapper.js', 9550], ['draco/draco_encoder.wasm', 62300], ['draco/draco_encoder.js', 6050], ['inline.js', 105300]])
  test(`the size of ${name}`, () => {
    const bytes = brotli(readFileSync(path.join(package_folder, name)));
    assert.ok(bytes < most, `${bytes} bytes in brotli`);
  });

for (const [name, most] of [['index.js', 12360], ['worker.js', 5000], ['three.js', 13330], ['babylon.js', 11880], ['asset.js', 10000], ['gltf-transform.js', 12420], ['encode.js', 8760], ['encode_worker.js', 5000], ['webgpu.js', 25700]])
  test(`the size of ${name} and what it imports, minified`, async () => {
    const bytes = brotli(await code_of_page(name));
    assert.ok(bytes < most, `${bytes} bytes in brotli`);
  });

test('the size of what webgpu.js imports for condensed patches', async () => {
  const bytes = brotli(await code_of_page('webgpu.js', 'webgpu/condensed.js'));
  assert.ok(bytes < 9200, `${bytes} bytes in brotli`);
});

test("docs/web.md's table has these sizes, up to 1 %", async () => {
  const page = readFileSync(path.join(package_folder, 'docs/web.md'), 'utf8');
  const file = (name) => readFileSync(path.join(package_folder, name)), wasm = file('psplit.wasm'), worker = await code_of_page('worker.js');
  const rows = {
    'psplit/draco': [file('draco/draco_wasm_wrapper.js'), file('draco/draco_decoder.wasm')], psplit: [wasm, await code_of_page('index.js'), worker],
    'psplit/gltf, no workers': [wasm, await code_of_page('asset.js')], 'psplit/three': [wasm, await code_of_page('three.js'), worker],
    'psplit/babylon': [wasm, await code_of_page('babylon.js'), worker], 'psplit/inline': [file('inline.js')],
  };
  const near = (stated, parts, size) => Math.abs(Number(stated.replaceAll(',', '')) / parts.reduce((sum, part) => sum + size(part), 0) - 1) < 0.01;
  for (const [name, parts] of Object.entries(rows)) {
    const [, bytes, packed] = page.match(new RegExp(`^\\| ${name} \\| ([\\d,]+) \\| ([\\d,]+) \\|$`, 'm')) ?? assert.fail(name);
    assert.ok(near(bytes, parts, (part) => part.length) && near(packed, parts, brotli), `${name}: scripts/web-bench --sizes prints the table`);
  }
});

test('the size of inline.js in a bundle of esbuild, as the README says', async () => {
  const { build } = createRequire(path.join(modules_folder, 'package.json'))('esbuild');
  const bundle = async (options) => (await build({ entryPoints: [path.join(package_folder, 'inline.js')], bundle: true, minify: true, format: 'esm',
    write: false, external: ['node:*'], logLevel: 'error', ...options })).outputFiles[0].contents.length;
  assert.match(readFileSync(path.join(package_folder, 'README.md'), 'utf8'), /`--charset=utf8`/);
  assert.ok(await bundle({ charset: 'utf8' }) < 1.05 * statSync(path.join(package_folder, 'inline.js')).size);
});
