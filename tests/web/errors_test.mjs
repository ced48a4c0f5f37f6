// Every rejection of the package is a PsplitError, with a code that fits and a message that says what to do: also for arguments
// that are none, for buffers that were given away, and for files that a server mixes up.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, package_folder, psplit, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const sample = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb');
const [{ bytes: container, attributes }] = compressed_primitives(sample, 'PSPLIT_mesh_draco_patches'), [[, stream]] = [...streams()];
const pool = psplit.createPool({ workers: 1 });
after(() => pool.dispose());

const functions = { decodeDraco: psplit.decodeDraco, decodeContainer: psplit.decodeContainer,
  'pool.decodeDraco': (...of) => pool.decodeDraco(...of), 'pool.decodeContainer': (...of) => pool.decodeContainer(...of),
  'pool.decodePatches': (...of) => pool.decodePatches(...of) };
const kInvalid = { name: 'PsplitError', code: 'invalid-input' };
const bytes_for = (name) => (name.endsWith('Draco') ? stream : container);

test('options that are none', async () => {
  for (const [name, decode] of Object.entries(functions)) {
    const given = bytes_for(name), onPart = () => {};
    for (const options of [{ attributes: [null] }, { attributes: 5 }, { attributes: [{ name: Object.create(null), uniqueId: 0, type: 'float32' }] }])
      await assert.rejects(decode(given, { onPart, ...options }), kInvalid, `${name} ${JSON.stringify(options)}`);
    for (const data of [undefined, null, 5, {}, [1, 2]]) await assert.rejects(decode(data, { onPart }), kInvalid, `${name} ${data}`);
    if (!name.startsWith('pool')) continue;
    for (const options of [{ signal: {} }, { signal: 5 }, { onProgress: 5 }, { workers: '2' }])
      await assert.rejects(decode(given, { onPart, ...options }), kInvalid, `${name} ${JSON.stringify(options)}`);
  }
  await assert.rejects(pool.decodePatches(container, null), kInvalid);
  for (const options of [null, undefined, { attributes: null }, { attributes: undefined, signal: null, onProgress: null }])
    for (const name of ['decodeDraco', 'decodeContainer', 'pool.decodeDraco', 'pool.decodeContainer'])
      assert.ok((await functions[name](bytes_for(name), options)).faceCount > 0, name);
  const stream_of = () => new Response(container).body, no_meshes = () => new Response('{}');
  const arriving = { decodeStream: stream_of, decodeUrl: no_meshes };
  for (const [name, given] of Object.entries(arriving)) {
    for (const options of [{ signal: {} }, { signal: 5 }]) await assert.rejects(pool[name](given(), options), kInvalid, `${name} ${JSON.stringify(options)}`);
    for (const options of [null, undefined, { signal: null, onProgress: null, onPart: null }]) await pool[name](given(), options);
    for (const data of [undefined, null, 5, {}]) await assert.rejects(pool[name](data), { name: 'PsplitError' }, `${name} ${data}`);
  }
  for (const options of [{ onProgress: 5 }, { onPart: 5 }, { workers: '2' }, { attributes: 5 }])
    await assert.rejects(pool.decodeStream(stream_of(), options), kInvalid, JSON.stringify(options));
  psplit.createPool(null).dispose();
});

test('buffers that were given away', async () => {
  const given_away = () => {
    const data = Uint8Array.from(stream);
    structuredClone(data, { transfer: [data.buffer] });
    return data;
  };
  for (const [name, decode] of Object.entries(functions))
    for (const data of [given_away(), given_away().buffer, new DataView(new ArrayBuffer(8))])
      await assert.rejects(decode(data, { attributes: name.endsWith('Draco') ? undefined : attributes, onPart() {} }), kInvalid, name);
  // After the call, which has copied nothing yet.
  const data = Uint8Array.from(stream), promise = pool.decodeDraco(data);
  structuredClone(data, { transfer: [data.buffer] });
  await assert.rejects(promise, kInvalid);
  assert.ok((await psplit.decodeDraco(stream)).faceCount > 0);
});

test('null in place of options of the plugins', async () => {
  const { GLTFLoader, PsplitDracoLoader, PsplitPlugin } = await import('./three_loaders.mjs');
  const { createDecoder, decodeAhead } = await import(pathToFileURL(path.join(package_folder, 'gltf-transform.js')));
  const { registerPsplit } = await import(pathToFileURL(path.join(package_folder, 'babylon.js')));
  assert.ok((await createDecoder(null)).decodeContainer(container, { attributes }).faceCount > 0);
  await decodeAhead({ json: {}, resources: {} }, pool, null);
  new PsplitDracoLoader(null).dispose();
  registerPsplit(() => {}, null);
  const loader = new GLTFLoader().register((parser) => new PsplitPlugin(parser, null));
  assert.ok((await loader.parseAsync(JSON.stringify({ asset: { version: '2.0' } }), '')).psplit instanceof PsplitPlugin);
});

const other_module = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0]);  // which is empty
async function failure_of(wasm) {
  const own = psplit.createPool({ workers: 1, wasm });
  try {
    return await own.decodeDraco(stream).then(() => assert.fail('it decodes'), (error) => error);
  } finally {
    own.dispose();
  }
}
test('a module that is another one', async () => {
  for (const wasm of [other_module, new WebAssembly.Module(other_module), readFileSync(path.join(package_folder, 'draco/draco_decoder.wasm'))]) {
    const { name, code, message } = await failure_of(wasm);
    assert.deepEqual([name, code, message], ['PsplitError', 'failed', 'the WebAssembly module is not psplit.wasm']);
  }
});

test('an address that has something else', async () => {
  const answers = { '/page.wasm': [200, 'text/html', '<!doctype html>'], '/page-as-wasm.wasm': [200, 'application/wasm', '<!doctype html>'],
    '/plain.wasm': [200, 'application/octet-stream', 'text'], '/none.wasm': [404, 'text/plain', 'none'] };
  const server = createServer(({ url }, response) => {
    const [status, type, body] = answers[url];
    response.writeHead(status, { 'Content-Type': type }).end(body);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve).unref());
  const address = (file) => `http://127.0.0.1:${server.address().port}${file}`;
  try {
    for (const [file, why] of [['/page.wasm', 'the server sent text/html in place of WebAssembly'],
      ['/page-as-wasm.wasm', 'the server sent something else than WebAssembly'],
      ['/plain.wasm', 'the server sent application/octet-stream in place of WebAssembly'], ['/none.wasm', 'HTTP status 404']]) {
      const { code, message } = await failure_of(address(file));
      assert.deepEqual([code, message], ['failed', `${address(file)} cannot be loaded: ${why}`]);
    }
  } finally {
    server.close();
    server.closeAllConnections();
  }
  assert.match((await failure_of('file:///nowhere/psplit.wasm')).message, /^file:\/\/\/nowhere\/psplit\.wasm cannot be loaded: ENOENT/);
});
