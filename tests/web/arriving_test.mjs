// Meshes are decoded while their bytes arrive: from streams of any chunks, and from a server.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { getEventListeners } from 'node:events';
import { createServer } from 'node:http';
import path from 'node:path';
import test, { after } from 'node:test';
import { pathToFileURL } from 'node:url';
import { compressed_primitives, fallback_files, gltf_psplit, make_container, package_folder, psplit, random_numbers, root, with_asset } from './load.mjs';
import { endless, in_chunks, serve_slowly, wait_ms } from './slow_server.mjs';
import { streams, with_draco_mesh } from './stock_draco.mjs';

const { decodeGlb, decodeGltf } = await import(pathToFileURL(path.join(package_folder, 'asset.js')));

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const sample = (name) => compressed_primitives(path.join(samples, `${name}.glb`), 'PSPLIT_mesh_draco_patches')[0];
const needs_tool = { skip: gltf_psplit === null && 'there is no gltf-psplit' };
// Long enough to be decoded before they are whole: Draco streams, condensed ones, and condensed ones with values at borders.
const long = gltf_psplit === null ? [] : [[], ['--condense'], ['--condense', '--profile', 'size']]
  .map((options) => [options.join(' '), make_container(60000, 2000, ...options)]);
const containers = [...['patches', 'condensed', 'condensed-borders', 'residue', 'condensed-residue', 'seams']
  .map((name) => [name, sample(name)]), ...long];

const pool = psplit.createPool({ workers: 2 });
after(() => pool.dispose());

test('chunks of any length become the same mesh', async () => {
  const below = random_numbers(1);
  for (const [name, { bytes, attributes }] of containers) {
    const expected = await psplit.decodeContainer(bytes, { attributes });
    for (const [length, pause] of [[() => 1 + below(3000)], [() => bytes.length], [() => 1 + below(20000), 1], [() => 40, undefined]]) {
      assert.deepEqual(await pool.decodeStream(in_chunks(bytes, length, pause), { attributes }), expected, name);
      const unnamed = await pool.decodeStream(in_chunks(bytes, length, pause));
      assert.deepEqual(unnamed.indices, expected.indices, name);
    }
    assert.deepEqual(await pool.decodeStream(new Response(bytes).body, { attributes }), expected, name);
  }
});

test('the calling thread decodes if no worker can be started', async () => {
  const { warn } = console, warnings = [], own = psplit.createPool({ workers: 2, worker: () => { throw new Error('broken'); } });
  console.warn = (text) => warnings.push(text);
  try {
    for (const [name, { bytes, attributes }] of containers) {
      const expected = await psplit.decodeContainer(bytes, { attributes });
      const stream = (length = 8000) => in_chunks(bytes, () => length, 1);
      let faces = 0;
      const onPart = ({ isFinal, indices }) => { faces += isFinal ? indices.length / 3 : 0; };
      const [mesh, other] = await Promise.all([own.decodeStream(stream(), { attributes, onPart }), own.decodeStream(stream(5000), { attributes })]);
      assert.deepEqual([mesh, other, faces], [expected, expected, expected.faceCount], name);
      const stop = new AbortController();
      const job = own.decodeStream(stream(), { attributes, signal: stop.signal, onPart: () => stop.abort() });
      await assert.rejects(job, { name: 'PsplitError', code: 'aborted' }, name);
    }
    assert.equal(own.workerCount, 0);
  } finally {
    console.warn = warn;
    own.dispose();
  }
  assert.match(warnings[0], /this thread decodes \(worker: broken\)$/);
});

test('patches come before the bytes behind them', needs_tool, async () => {
  for (const [name, { bytes, attributes }] of long) {
    const expected = await psplit.decodeContainer(bytes, { attributes });
    let sent = 0, streams = 0;
    const counts = [], is_there = new Uint8Array(expected.firstFaces.length - 1);
    async function* chunks() {
      for (const part of [0.5, 0.75, 1]) {
        yield bytes.slice(sent, (sent = Math.floor(part * bytes.length)));
        // The rest waits for the patches that have arrived.
        while (part < 1 && streams < (part - 0.1) * is_there.length) await wait_ms(1);
      }
    }
    const mesh = await pool.decodeStream(chunks(), { attributes, onProgress: (done, total) => counts.push([done, total]),
      onPart: ({ patches: [first, end], isFinal, indices, firstFace, firstPoint, attributes: values }) => {
        assert.ok(isFinal);
        is_there.fill(1, first, end);
        streams = end;
        assert.deepEqual(indices, expected.indices.slice(3 * firstFace, 3 * firstFace + indices.length));
        for (const [i, { array, componentCount }] of values.entries())
          assert.deepEqual(array, expected.attributes[i].array.slice(componentCount * firstPoint, componentCount * firstPoint + array.length));
      } });
    assert.deepEqual(mesh, expected, name);
    assert.ok(is_there.every((value) => value === 1));
    assert.ok(counts.length > 2 && counts.every(([done, total], i) => total === is_there.length && (i === 0 || done > counts[i - 1][0])));
  }
});

test('boxes have the points of their patches', needs_tool, async () => {
  for (const options of [[], ['--condense']]) {
    const { bytes, attributes } = make_container(60000, 2000, '--boxes', '--order', 'near:0,0,0', ...options);
    const mesh = await psplit.decodeContainer(bytes, { attributes }), { boxes, firstFaces, indices } = mesh, [{ array }] = mesh.attributes;
    assert.equal(boxes.length, 6 * (firstFaces.length - 1));
    let seen;
    assert.deepEqual(await pool.decodeStream(in_chunks(bytes, () => 9000, 1), { attributes, onPart: (part, of) => (seen ??= of.boxes) }), mesh);
    assert.deepEqual(seen, boxes);
    let last = 0, tight = 0;
    for (let patch = 0; patch + 1 < firstFaces.length; ++patch) {
      const low = [Infinity, Infinity, Infinity], high = low.map((value) => -value);
      let nearest = Infinity;
      for (let i = 3 * firstFaces[patch]; i < 3 * firstFaces[patch + 1]; ++i) {
        const position = array.subarray(3 * indices[i], 3 * indices[i] + 3);
        nearest = Math.min(nearest, Math.hypot(...position));
        position.forEach((value, axis) => {
          low[axis] = Math.min(low[axis], value);
          high[axis] = Math.max(high[axis], value);
        });
      }
      for (let axis = 0; axis < 3; ++axis) {
        assert.ok(boxes[6 * patch + axis] <= low[axis] && boxes[6 * patch + 3 + axis] >= high[axis]);
        tight += high[axis] - low[axis] > 0.9 * (boxes[6 * patch + 3 + axis] - boxes[6 * patch + axis]) ? 1 : 0;
      }
      assert.ok(nearest > last - 1e-3, 'patches are not in the order that was asked for');
      last = nearest;
    }
    assert.ok(tight > boxes.length / 4);
  }
});

test('errors of a stream', async () => {
  const invalid = { name: 'PsplitError', code: 'invalid-input' };
  for (const [name, { bytes, attributes }] of containers) {
    const decode = (changed, length = () => 5000) => pool.decodeStream(in_chunks(changed, length, 0), { attributes });
    const longer = new Uint8Array(bytes.length + 1), broken = Uint8Array.from(bytes);
    longer.set(bytes);
    broken.fill(0xff, bytes.length - 60);
    await assert.rejects(decode(bytes.subarray(0, -1)), { ...invalid, message: /its length is not/ }, name);
    await assert.rejects(decode(longer), { ...invalid, message: /its length is not/ }, name);
    await assert.rejects(decode(broken), invalid, name);
    await assert.rejects(decode(bytes.subarray(1)), { ...invalid, message: /wrong magic/ }, name);
    await assert.rejects(decode(bytes.subarray(0, 10)), { ...invalid, message: /shorter than its header/ }, name);
  }
  const [, { bytes }] = containers.at(-1);
  await assert.rejects(pool.decodeStream([1, 2, 3]), invalid);
  await assert.rejects(pool.decodeStream((async function* () { yield 'text'; })()), invalid);
  await assert.rejects(pool.decodeStream((async function* () { yield bytes.slice(0, 20000); throw new Error('lost'); })()),
    { name: 'PsplitError', code: 'failed', message: 'lost' });
  let cancelled = false;
  const endless = new ReadableStream({ pull: (controller) => wait_ms(1).then(() => controller.enqueue(bytes.slice(1, 20000))), cancel: () => { cancelled = true; } });
  await assert.rejects(pool.decodeStream(endless), invalid);
  assert.ok(cancelled);
  const thrown = new Error('of the caller');
  await assert.rejects(pool.decodeStream(in_chunks(bytes, () => 9000, 1), { onPart: () => { throw thrown; } }), thrown);
});

test('an abort cancels the stream', async () => {
  const [, { bytes }] = containers.at(-1), stop = new AbortController();
  let cancelled;
  const stream = new ReadableStream({ start: (controller) => controller.enqueue(bytes.slice(0, 20000)), cancel: () => { cancelled = true; } });
  const job = pool.decodeStream(stream, { signal: stop.signal });
  setTimeout(() => stop.abort(), 50);
  await assert.rejects(job, { name: 'PsplitError', code: 'aborted' });
  assert.ok(cancelled);
  assert.ok((await pool.decodeContainer(bytes)).faceCount > 0);  // the pool goes on
});

const slowly = (bytes) => () => in_chunks(bytes, () => 16000, 5), at_once = (bytes) => () => [bytes];

test('decodeUrl: a container, a GLB, a glTF file and its buffer', async () => {
  const glb = new Uint8Array(readFileSync(path.join(samples, 'patches.glb')));
  const { bytes, attributes } = sample('patches'), files = { '/mesh.bin': at_once(bytes), '/patches.glb': slowly(glb) };
  for (const name of fallback_files)
    files[`/${name}`] = at_once(readFileSync(path.join(samples, name)));
  const { origin } = await serve_slowly(files), expected = await psplit.decodeContainer(bytes, { attributes });

  const { json: none, primitives: [alone] } = await pool.decodeUrl(`${origin}/mesh.bin`, { attributes });
  assert.deepEqual([none, alone], [null, expected]);

  const places = [];
  const { json, primitives } = await pool.decodeUrl(new URL(`${origin}/patches.glb`), { onPart: (part, counts, place) => places.push(place) });
  assert.equal(json.asset.version, '2.0');
  assert.deepEqual(primitives, [{ mesh: 0, primitive: 0, ...expected }]);
  assert.deepEqual(places[0], { mesh: 0, primitive: 0 });

  const { primitives: [other] } = await pool.decodeUrl(await fetch(`${origin}/fallback.gltf`));
  assert.ok(other.faceCount > 0);
});

test('decodeUrl: errors', async () => {
  const { bytes } = sample('patches'), glb = readFileSync(path.join(samples, 'patches.glb')), broken = Uint8Array.from(glb);
  broken.fill(0xff, glb.length - 60);
  const { origin } = await serve_slowly({ '/text': at_once(Buffer.from('<!doctype html>')), '/cut.glb': at_once(glb.subarray(0, -8)),
    '/empty': () => [], '/cut': at_once(bytes.subarray(0, 30)), '/head.glb': at_once(glb.subarray(0, 30)), '/broken.glb': at_once(broken) });
  const rejects = (name, error) => assert.rejects(pool.decodeUrl(`${origin}/${name}`), { name: 'PsplitError', ...error });
  await rejects('missing', { code: 'failed', message: /missing: HTTP status 404/ });
  await rejects('text', { code: 'invalid-input', message: /no GLB/ });
  await rejects('empty', { code: 'invalid-input' });
  await rejects('cut', { code: 'invalid-input' });
  await rejects('head.glb', { code: 'invalid-input', message: /head\.glb: it ends early, after 30 of at least \d+ bytes$/ });
  for (const meshes of [5, [null], [{}], [{ primitives: [null] }], [{ primitives: [{ extensions: { PSPLIT_mesh_draco_patches: null } }] }]]) {
    const text = JSON.stringify({ asset: { version: '2.0' }, meshes });
    await assert.rejects(pool.decodeUrl(new Response(text)), { name: 'PsplitError', code: 'invalid-input', message: /malformed|mesh 0, primitive 0: the container has no buffer view/ }, text);
  }
  await rejects('cut.glb', { code: 'invalid-input', message: /^mesh 0, primitive 0: .*cut\.glb: it ends early, after \d+ of at least \d+ bytes$/, mesh: 0, primitive: 0 });
  await rejects('broken.glb', { code: 'invalid-input', mesh: 0, primitive: 0 });
  await assert.rejects(pool.decodeUrl('http://127.0.0.1:9/'), { name: 'PsplitError', code: 'failed' });
  await assert.rejects(pool.decodeUrl('no address'), { name: 'PsplitError', code: 'failed' });
});

test('decodeUrl: the first patch comes early, and `signal` ends it at once', { ...needs_tool, timeout: 120000 }, async () => {
  const glb = with_asset(60000, ['--patch-faces', '2000'], (file) => new Uint8Array(readFileSync(file)));
  const chunks = () => in_chunks(glb, () => Math.ceil(glb.length / 20), 30);
  let part_count = 0;
  async function* held() {
    let sent = 0;
    for await (const chunk of chunks()) {
      // The second half waits for the first patches.
      while (2 * sent > glb.length && part_count === 0) await wait_ms(1);
      sent += chunk.length;
      yield chunk;
    }
  }
  const { origin, open, done } = await serve_slowly({ '/whole.glb': held, '/aborted.glb': chunks });
  await pool.decodeUrl(`${origin}/whole.glb`, { onPart: () => ++part_count });
  assert.ok(part_count > 1);

  const stop = new AbortController();
  const job = pool.decodeUrl(`${origin}/aborted.glb`, { signal: stop.signal, onPart: () => stop.abort() });
  await assert.rejects(job, { name: 'PsplitError', code: 'aborted' });
  assert.ok(!done.has('/aborted.glb'));
  while (open.has('/aborted.glb')) await wait_ms(1);  // the download has ended as well
  await assert.rejects(pool.decodeUrl(`${origin}/whole.glb`, { signal: AbortSignal.abort() }), { code: 'aborted' });
});

// Otherwise a browser would report a failed request, and would not keep the file in its cache.
test('a response all of whose bytes were used is not aborted', async () => {
  const glb = readFileSync(path.join(samples, 'patches.glb')), sent = [];
  async function* late() {
    yield glb;
    await new Promise((resolve) => sent.push(resolve));
  }
  const { origin, open, done } = await serve_slowly({ '/a.glb': late, '/chosen.glb': late });
  await pool.decodeUrl(`${origin}/a.glb`);
  await pool.decodeUrl(`${origin}/chosen.glb`, { choose: () => null });
  await wait_ms(100);
  assert.deepEqual(open, new Set(['/a.glb', '/chosen.glb']));
  for (const end of sent) end();
  while (done.size < 2 || open.size > 0) await wait_ms(1);
});

test('downloads end that nobody needs any more, and responses that never end', { timeout: 60000 }, async () => {
  const glb = readFileSync(path.join(samples, 'patches.glb'));
  const { origin, open } = await serve_slowly({ '/a.glb': () => endless(glb), '/b.glb': () => endless(glb.subarray(0, -8)) });
  await pool.decodeUrl(`${origin}/a.glb`);
  const stop = new AbortController(), job = pool.decodeUrl(`${origin}/b.glb`, { signal: stop.signal });
  setTimeout(() => stop.abort(), 50);
  await assert.rejects(job, { code: 'aborted' });
  while (open.size > 0) await wait_ms(1);
});

// A server that promises more bytes than it sends, and one whose connection breaks.
test('a response that ends early says so', async () => {
  const glb = readFileSync(path.join(samples, 'patches.glb')), server = createServer(({ url }, response) => {
    response.writeHead(200, url === '/promised.glb' ? { 'Content-Length': glb.length } : {});
    response.write(glb.subarray(0, -400), () => setTimeout(() => response.destroy(), 20));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  try {
    for (const name of ['promised.glb', 'broken.glb']) {
      const url = `http://127.0.0.1:${server.address().port}/${name}`;
      await assert.rejects(pool.decodeUrl(url), { code: 'failed', message: new RegExp(`${name}: it ended early, after \\d+ bytes`) });
      await assert.rejects(decodeGltf(url), { code: 'failed', message: new RegExp(`${name} cannot be loaded: it ended early`) });
    }
  } finally {
    server.close();
  }
  await assert.rejects(decodeGlb(glb.subarray(0, -400)), { code: 'invalid-input', message: `the GLB ends early: ${glb.length - 400} of ${glb.length} bytes` });
});

test('decodeUrl reads files of this machine', async () => {
  const url = (name) => pathToFileURL(path.join(samples, name)), { bytes, attributes } = sample('patches');
  const expected = await psplit.decodeContainer(bytes, { attributes });
  for (const options of [{}, { choose: () => undefined }])
    for (const address of [url('patches.glb'), url('patches.glb').href])
      assert.deepEqual((await pool.decodeUrl(address, options)).primitives, [{ mesh: 0, primitive: 0, ...expected }]);
  assert.ok((await pool.decodeUrl(url('fallback.gltf'))).primitives[0].faceCount > 0);  // its container is in another file
  const { primitives: [{ chosen }] } = await pool.decodeUrl(url('patches.glb'), { choose: () => [1] });
  assert.deepEqual(chosen, Uint32Array.of(1));
  await assert.rejects(pool.decodeUrl(url('none.glb')), { code: 'failed', message: /none\.glb: .*ENOENT/ });
});

test('many jobs with one signal: no warning, and no listener stays', async () => {
  const [[, stream]] = streams(), { signal } = new AbortController(), warnings = [], warn = (warning) => warnings.push(warning.message);
  let glb = readFileSync(path.join(samples, 'patches.glb'));
  for (let i = 0; i < 14; ++i) glb = with_draco_mesh(glb, stream);
  process.on('warning', warn);
  try {
    assert.equal((await decodeGlb(glb, { pool, signal })).primitives.length, 15);
    await Promise.all(Array.from({ length: 15 }, () => pool.decodeDraco(stream, { signal })));
    await wait_ms(20);
  } finally {
    process.off('warning', warn);
  }
  assert.deepEqual(warnings, []);
  assert.deepEqual(getEventListeners(signal, 'abort'), []);
});
