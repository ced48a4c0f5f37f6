// The package in the runtimes of servers and of the edge of networks: workerd, Deno and Bun. tests/web/package.json has them as
// optional packages, since not every system has each.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { link_package, modules_folder, package_folder, readme_blocks, root } from './load.mjs';
import { draco_glb, streams } from './stock_draco.mjs';

link_package();
const { build } = createRequire(path.join(modules_folder, 'package.json'))('esbuild');
const { decodeGlb } = await import(pathToFileURL(path.join(package_folder, 'asset.js')));
const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb'), [[, stream]] = [...streams()];
const folder = path.join(root, 'build/web/edge');
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const draco = path.join(folder, 'draco.glb');
writeFileSync(draco, draco_glb(stream));

// The reason why a runtime's tests do not run, or false. Its package may be there without its program.
const command = (name) => path.join(modules_folder, 'node_modules/.bin', name);
function skip(name) {
  try {
    execFileSync(command(name), ['--version'], { stdio: 'pipe', timeout: 20000 });
    return false;
  } catch (error) {
    return `${name} does not run: ${existsSync(command(name)) ? error.message : 'npm did not install it'}`;
  }
}

test("workerd runs the README's code", { skip: skip('workerd'), timeout: 60000 }, async () => {
  const [code] = readme_blocks()['At the edge'];
  // Wrangler bundles workers like this: modules of WebAssembly stay files.
  const wasm_files = { name: 'wasm', setup({ onResolve }) {
    onResolve({ filter: /\.wasm$/ }, () => ({ path: './psplit.wasm', external: true }));
  } };
  await build({ stdin: { contents: code, resolveDir: modules_folder, loader: 'ts' }, bundle: true, format: 'esm', logLevel: 'error',
    outfile: path.join(folder, 'main.js'), conditions: ['workerd', 'worker', 'browser'], plugins: [wasm_files] });
  copyFileSync(path.join(package_folder, 'psplit.wasm'), path.join(folder, 'psplit.wasm'));
  writeFileSync(path.join(folder, 'config.capnp'), `using Workerd = import "/workerd/workerd.capnp";
    const config :Workerd.Config = (
      services = [(name = "main", worker = (compatibilityDate = "2025-01-01", modules = [
        (name = "main.js", esModule = embed "main.js"), (name = "psplit.wasm", wasm = embed "psplit.wasm")]))],
      sockets = [(name = "http", address = "127.0.0.1:0", http = (), service = "main")]);`);
  const workerd = spawn(command('workerd'), ['serve', '--control-fd=3', 'config.capnp'],
    { cwd: folder, stdio: ['ignore', 'inherit', 'inherit', 'pipe'] });
  try {
    const port = await new Promise((resolve, reject) => {
      let text = '';
      workerd.stdio[3].on('data', (data) => {
        const listens = (text += data).split('\n').slice(0, -1).map(JSON.parse).find(({ event }) => event === 'listen');
        if (listens) resolve(listens.port);
      });
      workerd.on('error', reject).on('exit', (status) => reject(new Error(`workerd ended with ${status}`)));
    });
    for (const file of [sample, draco]) {
      const bytes = readFileSync(file), { primitives } = await decodeGlb(bytes);
      const response = await fetch(`http://127.0.0.1:${port}/`, { method: 'POST', body: bytes });
      assert.equal(response.status, 200);
      assert.deepEqual(await response.json(),
        primitives.map(({ indices, attributes }) => [indices.length, attributes.POSITION.array.length]));
    }
  } finally {
    workerd.kill('SIGKILL');
  }
});

// Prints the digests of what decodeGlb returns: with the module beside the code, with a compiled one, and from workers.
const program = `
  import { createHash } from 'node:crypto';
  import { readFileSync } from 'node:fs';
  const [at, ...files] = process.argv.slice(2);
  const { configure, createPool } = await import(at + 'index.js'), { decodeGlb } = await import(at + 'asset.js');
  const pool = createPool({ workers: 2, mainThread: false }), digests = [];
  async function decode(options) {
    for (const file of files) {
      const { primitives } = await decodeGlb(readFileSync(file), options), hash = createHash('sha256');
      for (const { indices, attributes } of primitives)
        for (const { buffer, byteOffset, byteLength } of [indices, ...Object.values(attributes).map(({ array }) => array)])
          hash.update(new Uint8Array(buffer, byteOffset, byteLength));
      digests.push(hash.digest('hex'));
    }
  }
  await decode();
  configure({ wasm: new WebAssembly.Module(readFileSync(new URL(at + 'psplit.wasm'))) });
  await decode();
  await decode({ pool });
  pool.dispose();
  console.log(JSON.stringify(digests));`;
writeFileSync(path.join(folder, 'program.mjs'), program);
const digests = (file, ...options) => JSON.parse(execFileSync(file, [...options, path.join(folder, 'program.mjs'),
  pathToFileURL(package_folder).href + '/', sample, draco], { encoding: 'utf8', timeout: 60000 }));
const expected = digests(process.execPath);

for (const [name, ...options] of [['deno', 'run', '--no-config', '--no-remote', '--allow-read'], ['bun', 'run']])
  test(`${name} decodes what Node.js decodes`, { skip: skip(name), timeout: 90000 }, () => {
    assert.equal(new Set(expected).size, 2);
    assert.deepEqual(digests(command(name), ...options), expected);
  });
