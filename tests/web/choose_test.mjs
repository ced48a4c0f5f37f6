// decodeUrl with `choose`: some patches of a file are decoded, and from servers that send ranges only their bytes are fetched.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after } from 'node:test';
import { page_test } from './browser.mjs';
import { compressed_primitives, gltf_psplit, psplit, random_numbers, root, with_asset } from './load.mjs';
import { endless, in_chunks, part_of_file, serve_ranges, serve_slowly, wait_ms } from './slow_server.mjs';

const samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const read_sample = (name) => new Uint8Array(readFileSync(path.join(samples, name)));
const sample = (name) => compressed_primitives(path.join(samples, `${name}.glb`), 'PSPLIT_mesh_draco_patches')[0];
const needs_tool = { skip: gltf_psplit === null && 'there is no gltf-psplit' };
// Draco streams, condensed ones, and condensed ones with values at borders: files and their containers.
const kinds = [['--boxes'], ['--condense', '--boxes'], ['--condense', '--profile', 'size']];
const made = gltf_psplit === null ? [] : kinds.map((options) => with_asset(60000, ['--patch-faces', '500', ...options], (file) =>
  [new Uint8Array(readFileSync(file)), compressed_primitives(file, 'PSPLIT_mesh_draco_patches')[0]]));
const large = made.map(([glb]) => glb);
const containers = [...['patches', 'condensed', 'condensed-borders', 'residue', 'condensed-residue', 'seams']
  .map((name) => [name, sample(name)]), ...made.map(([, container], i) => [kinds[i].join(' '), container])];

const pool = psplit.createPool({ workers: 2 });
after(() => pool.dispose());

const invalid = { name: 'PsplitError', code: 'invalid-input' }, failed = { name: 'PsplitError', code: 'failed' };
const aborted = { name: 'PsplitError', code: 'aborted' };
const serve_file = (bytes) => serve_ranges((name, range) => part_of_file(bytes, range));
const slowly = (bytes) => new Response(new ReadableStream({ async start(controller) {
  for await (const chunk of in_chunks(bytes, () => 7000, 0)) controller.enqueue(chunk);
  controller.close();
} }));

// The bytes of the values of each corner of a patch.
const corners = (mesh, patch) => mesh.attributes.map(({ array, componentCount }) => {
  const points = mesh.indices.subarray(3 * mesh.firstFaces[patch], 3 * mesh.firstFaces[patch + 1]);
  const values = new array.constructor(points.length * componentCount);
  points.forEach((point, i) => values.set(array.subarray(componentCount * point, componentCount * (point + 1)), componentCount * i));
  return Buffer.from(values.buffer);
});
// A signal that aborts, and does not let the process end before.
const abort_after = (time) => {
  const stop = new AbortController();
  setTimeout(() => stop.abort(), time);
  return stop.signal;
};
// The ranges that use() asks for, in their order.
async function asked_by(use) {
  const { fetch } = globalThis, ranges = [];
  globalThis.fetch = (input, options) => {
    ranges.push(new Headers(options.headers).get('Range').slice(6).split('-').map(Number));
    return fetch(input, options);
  };
  try {
    await use();
  } finally {
    globalThis.fetch = fetch;
  }
  return ranges;
}

// Whether a mesh of chosen patches has what the whole has.
function check_chosen(some, whole, chosen, name) {
  assert.deepEqual([[...some.chosen], some.patchCount, some.hasResidue, some.firstFaces.length], [chosen, chosen.length, false, chosen.length + 1], name);
  assert.deepEqual([some.firstFaces.at(-1), some.firstPoints.at(-1), some.indices.length], [some.faceCount, some.pointCount, 3 * some.faceCount], name);
  for (const { array, componentCount } of some.attributes) assert.equal(array.length, some.pointCount * componentCount, name);
  for (const [i, patch] of chosen.entries()) {
    const values = corners(whole, patch);
    for (const [k, own] of corners(some, i).entries()) assert.ok(own.equals(values[k]), `${name}, patch ${patch}`);
    const faces = some.indices.subarray(3 * some.firstFaces[i], 3 * some.firstFaces[i + 1]);
    assert.ok(faces.every((point) => point >= some.firstPoints[i] && point < some.firstPoints[i + 1]), name);
    assert.deepEqual(some.boxes?.slice(6 * i, 6 * i + 6), whole.boxes?.slice(6 * patch, 6 * patch + 6), name);
  }
}

test('chosen patches have the values of the whole', async () => {
  const below = random_numbers(3);
  for (const [name, { bytes, attributes }] of containers) {
    const whole = await psplit.decodeContainer(bytes, { attributes }), { origin } = await serve_file(bytes), { patchCount } = whole;
    const numbers = Array.from({ length: patchCount }, (_, i) => i), backwards = [...numbers].reverse();
    const some = Array.from({ length: 5 }, () => below(patchCount)), told = [];
    for (const chosen of [numbers, backwards, [patchCount - 1], [...new Set(some)]])
      for (const input of [`${origin}/mesh.bin`, slowly(bytes)]) {
        const choose = (container) => { told.push(container); return new Set(chosen); };
        const { json, primitives: [mesh] } = await pool.decodeUrl(input, { attributes, choose });
        assert.equal(json, null);
        check_chosen(mesh, whole, chosen, name);
      }
    const { primitives: [unnamed] } = await pool.decodeUrl(`${origin}/mesh.bin`, { choose: () => backwards });
    assert.deepEqual(unnamed.indices.length, whole.indices.length - 3 * (whole.hasResidue ? whole.faceCount - whole.firstFaces[patchCount] : 0), name);
    for (const { byteLengths, faceCounts, boxes, ...counts } of told) {
      assert.deepEqual(counts, { patchCount });
      assert.ok(byteLengths.length === patchCount && byteLengths.every((length) => length > 0), name);
      assert.deepEqual([...faceCounts], numbers.map((i) => whole.firstFaces[i + 1] - whole.firstFaces[i]), name);
      assert.deepEqual(boxes, whole.boxes?.slice(0, 6 * patchCount), name);
    }
    assert.equal(told.length, 8);
    // Nothing is the whole mesh, and no patches are none.
    for (const given of [undefined, null, Promise.resolve()])
      assert.deepEqual((await pool.decodeUrl(`${origin}/mesh.bin`, { attributes, choose: () => given })).primitives, [whole], name);
    const { primitives: [none] } = await pool.decodeUrl(`${origin}/mesh.bin`, { attributes, choose: () => [] });
    assert.deepEqual([none.faceCount, none.indices.length, none.chosen.length, ...none.attributes.map(({ array }) => array.length)],
      [0, 0, 0, ...attributes.map(() => 0)], name);
  }
});

test('bytes of other patches are not fetched', needs_tool, async (t) => {
  for (const [at, glb] of large.entries()) {
    const name = kinds[at].join(' '), { origin, asked, sent } = await serve_file(glb);
    const { primitives: [whole] } = await pool.decodeUrl(`${origin}/a.glb`);
    assert.equal(sent(), glb.length);
    // A tenth of the patches is chosen: in a row, from everywhere, and the first ones in reverse order.
    const count = Math.ceil(whole.patchCount / 10), tenth = Array.from({ length: count }, (_, i) => i);
    for (const [chosen, most] of [[tenth.map((i) => 40 + i), 0.35], [tenth.map((i) => 10 * ((7 * i) % count)), 0.8], [[...tenth].reverse(), 0.25]]) {
      const before = sent(), first = asked.length, parts = [];
      let wanted = 0;
      const { primitives: [some] } = await pool.decodeUrl(`${origin}/a.glb`, { onPart: (part, { chosen: numbers }) => parts.push([part.patches, numbers]),
        choose: ({ mesh, primitive, byteLengths }) => {
          assert.deepEqual([mesh, primitive], [0, 0]);
          wanted = chosen.reduce((sum, i) => sum + byteLengths[i], 0);
          return chosen;
        } });
      check_chosen(some, whole, chosen, name);
      const fetched = sent() - before, requests = asked.slice(first);
      t.diagnostic(`${name}: ${chosen.length} of ${whole.patchCount} patches, ${wanted} bytes: ${fetched} of ${glb.length} in ${requests.length} requests`);
      assert.ok(fetched >= wanted && fetched < most * glb.length, `${name}: ${fetched} of ${glb.length}`);
      assert.ok(requests.every((range) => range !== null), name);
      // In the order of choose(), and each part is told by its place there.
      assert.ok(parts.every(([[begin, end], numbers], i) => begin === (i === 0 ? 0 : parts[i - 1][0][1]) && end > begin && numbers.length === chosen.length), name);
    }
    const before = sent();
    await pool.decodeUrl(`${origin}/a.glb`, { choose: () => [] });
    assert.ok(sent() - before < 20000 && before > 0, name);
  }
});

test('patches are asked for in the order of choose()', needs_tool, async () => {
  const [glb] = large, { streams, lengths } = await places_of(glb), { origin } = await serve_file(glb), count = lengths.length;
  for (const chosen of [[50, 90, 10, 70, 30, 110], [50, 49, 90, 51, 10, 88, 91], Array.from({ length: count }, (_, i) => count - 1 - i)]) {
    const [[, head], ...ranges] = await asked_by(() => pool.decodeUrl(`${origin}/a.glb`, { choose: () => chosen }));
    // The first bytes of the file are there already, perhaps with a part of a patch.
    const requests = chosen.filter((patch) => streams[patch] + lengths[patch] - 1 > head).map((patch) =>
      ranges.findIndex(([begin, last]) => begin <= Math.max(streams[patch], head + 1) && streams[patch] + lengths[patch] - 1 <= last));
    assert.ok(requests.length > 4 && new Set(requests).size === ranges.length);
    // Each is in the next request, or in one before it that has its neighbours.
    assert.ok(requests.every((i, k) => i <= Math.max(-1, ...requests.slice(0, k)) + 1), requests.join());
    if (chosen.length === 7) assert.deepEqual(ranges.length, 3);
    if (chosen.length === count) assert.ok(ranges.every(([begin, last]) => last - begin < 262144) && ranges.length < 5);
  }
});

// Where the container of a GLB and its streams begin in the file.
async function places_of(glb) {
  const view = new DataView(glb.buffer, glb.byteOffset), json = JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + view.getUint32(12, true))));
  const { byteOffset = 0, byteLength } = json.bufferViews[json.meshes[0].primitives[0].extensions.PSPLIT_mesh_draco_patches.bufferView];
  const container = 28 + view.getUint32(12, true) + byteOffset;
  let lengths;
  await pool.decodeUrl(new Response(glb), { choose: ({ byteLengths }) => { lengths = byteLengths; return []; } });
  let at = container + byteLength - lengths.reduce((sum, length) => sum + length, 0);
  return { container, lengths, streams: Array.from(lengths, (length) => (at += length) - length) };
}

test('a server that does not send ranges', needs_tool, async () => {
  for (const glb of large) {
    const { primitives: [whole] } = await pool.decodeUrl(new Response(glb)), chosen = [2, 5, 3];
    const { origin, done } = await serve_slowly({ '/a.glb': () => in_chunks(glb, () => Math.ceil(glb.length / 30), 20) });
    const { primitives: [some] } = await pool.decodeUrl(`${origin}/a.glb`, { choose: () => chosen });
    check_chosen(some, whole, chosen);
    assert.ok(!done.has('/a.glb'));  // the bytes after the chosen patches are not needed
  }
});

test('servers whose ranges cannot be used send the whole file', needs_tool, async () => {
  const [glb] = large, { primitives: [whole] } = await pool.decodeUrl(new Response(glb)), chosen = [70, 2, 3];
  const changed = (change) => async (name, range) => {
    const answer = part_of_file(glb, range);
    return range === null ? answer : { ...answer, ...change(answer, range) };
  };
  const without = (name, more = {}) => ({ headers }) => ({ headers: { ...Object.fromEntries(Object.entries(headers).filter(([key]) => key !== name)), ...more } });
  const cases = { 'no tag': without('ETag'), 'a weak tag': without('ETag', { ETag: 'W/"1"' }), 'no Content-Range': without('Content-Range'),
    'a new date': without('ETag', { 'Last-Modified': new Date(Date.now() + 2000).toUTCString() }),
    'no total': without('Content-Range', { 'Content-Range': 'bytes 0-16383/*' }), 'another range': without('Content-Range', { 'Content-Range': 'bytes 1-16384/99999' }),
    'other units': without('Content-Range', { 'Content-Range': 'lines 0-16383/99999' }), 'an encoding': without('', { 'Content-Encoding': 'identity' }),
    'no ranges at all': () => ({ status: 416, body: '' }) };
  for (const [name, change] of Object.entries(cases)) {
    const { origin, asked } = await serve_ranges(changed(change));
    const { primitives: [some] } = await pool.decodeUrl(`${origin}/a.glb`, { choose: () => chosen });
    check_chosen(some, whole, chosen, name);
    assert.deepEqual(asked, [[0, 16384], null], name);
  }
  // A request that is none of ours is left as it is.
  const { origin, asked } = await serve_file(glb);
  await pool.decodeUrl(new Request(`${origin}/a.glb`, { headers: { 'X-Key': '1' } }), { choose: () => chosen });
  assert.ok(asked.length > 1 && !asked.includes(null));
  await assert.rejects(pool.decodeUrl(new Request(`${origin}/a.glb`, { headers: { Range: 'bytes=0-99' } }), { choose: () => chosen }), invalid);
});

test('a file that changes midway is an error', needs_tool, async () => {
  const [glb] = large, [, other] = large, old = 'Wed, 21 Oct 2015 07:28:00 GMT', young = 'Thu, 22 Oct 2015 07:28:00 GMT';
  const decode = (origin) => pool.decodeUrl(`${origin}/a.glb`, { choose: () => [90, 60] });
  const seen = [];
  // As servers do that know If-Range: another file is sent whole.
  const honest = (tags) => async (name, range, headers) => {
    const is_new = range[0] > 0, own = is_new ? tags[1] : tags[0];
    seen.push(headers['if-range']);
    const answer = part_of_file(is_new ? other : glb, is_new && headers['if-range'] !== Object.values(own)[0] ? null : range);
    return { ...answer, headers: { ...answer.headers, ETag: [], ...own } };
  };
  // As servers that do not.
  const careless = (tags) => async (name, range) => {
    const answer = part_of_file(glb, range);
    return { ...answer, headers: { ...answer.headers, ETag: [], ...(range[0] > 0 ? tags[1] : tags[0]) } };
  };
  for (const answer of [honest, careless])
    for (const tags of [[{ ETag: '"1"' }, { ETag: '"2"' }], [{ 'Last-Modified': old }, { 'Last-Modified': young }], [{ ETag: '"1"' }, { ETag: 'W/"1"' }]]) {
      const { origin } = await serve_ranges(answer(tags));
      await assert.rejects(decode(origin), { ...failed, message: /^mesh 0, primitive 0: http:.*: the file changed while it was read$/ });
    }
  assert.deepEqual(seen.slice(0, 2), [undefined, '"1"']);
  assert.ok(seen.includes(old));
  // The server sends the file with a date in place of a tag, then whole although a range was asked for.
  const whole = (await pool.decodeUrl(new Response(glb))).primitives[0];
  for (const answer of [honest([{ 'Last-Modified': old }, { 'Last-Modified': old }]), async (name, range) => part_of_file(glb, range[0] > 0 ? null : range)]) {
    const { origin } = await serve_ranges(answer === undefined ? null : async (name, range, headers) => {
      const given = await answer(name, range, headers);
      return { ...given, body: range[0] > 0 && given.status === 206 ? glb.subarray(range[0], range[1]) : given.body,
        headers: { ...given.headers, ...(given.status === 206 && { 'Content-Range': `bytes ${range[0]}-${range[1] - 1}/${glb.length}` }) } };
    });
    check_chosen((await decode(origin)).primitives[0], whole, [90, 60]);
  }
});

test('wrong ranges are errors', needs_tool, async () => {
  const [glb] = large;
  const cases = {
    'another begin': (answer, [begin, end]) => ({ headers: { ...answer.headers, 'Content-Range': `bytes ${begin + 1}-${end - 1}/${glb.length}` } }),
    'another end': (answer, [begin, end]) => ({ headers: { ...answer.headers, 'Content-Range': `bytes ${begin}-${end - 2}/${glb.length}` } }),
    'another length of the file': (answer, [begin, end]) => ({ headers: { ...answer.headers, 'Content-Range': `bytes ${begin}-${end - 1}/${glb.length + 1}` } }),
    'a huge range': (answer, [begin]) => ({ headers: { ...answer.headers, 'Content-Range': `bytes ${begin}-${'9'.repeat(15)}/${'9'.repeat(15)}` } }),
    'no range': (answer) => ({ headers: { ...answer.headers, 'Content-Range': [] } }),
    'fewer bytes': ({ body }) => ({ body: body.subarray(0, -1) }),
    'no bytes': () => ({ body: new Uint8Array() }),
    'more bytes': ({ body }) => ({ body: Buffer.concat([body, new Uint8Array(9)]) }),
    'no such range': () => ({ status: 416, body: '' }),
    'no such file': () => ({ status: 404, body: '' }),
    'an error': () => ({ status: 503, body: '' }),
    'no content': () => ({ status: 204, body: '' }),
  };
  for (const [name, change] of Object.entries(cases)) {
    const { origin } = await serve_ranges((path_, range) => {
      const answer = part_of_file(glb, range);
      return range[0] === 0 ? answer : { ...answer, ...change(answer, range) };
    });
    await assert.rejects(pool.decodeUrl(`${origin}/a.glb`, { choose: () => [90, 60] }), { ...failed, mesh: 0, primitive: 0 }, name);
  }
  const { origin } = await serve_ranges((name, range) => (range[0] === 0 ? part_of_file(glb, range) : new Promise(() => {})));
  await assert.rejects(pool.decodeUrl(`${origin}/a.glb`, { choose: () => [90, 60], signal: abort_after(200) }), aborted);
  await assert.rejects(pool.decodeUrl('http://127.0.0.1:9/', { choose: () => [] }), failed);
  const { origin: missing } = await serve_ranges(() => ({ status: 404, headers: {}, body: '' }));
  await assert.rejects(pool.decodeUrl(`${missing}/a.glb`, { choose: () => [] }), { ...failed, message: /HTTP status 404$/ });
});

test('errors have the numbers of the whole container', async () => {
  for (const [name, { bytes, attributes }] of containers) {
    const { lengths, streams } = await places_of_container(bytes), last = lengths.length - 1;
    const broken = Uint8Array.from(bytes);
    broken.fill(0xff, streams[last], streams[last] + lengths[last]);
    const { origin } = await serve_file(broken), decode = (chosen) => pool.decodeUrl(`${origin}/a`, { attributes, choose: () => chosen });
    await assert.rejects(decode([last]), { ...invalid, patch: last, message: /^(?!.*patch -)/ }, name);
    if (last === 0) continue;
    await assert.rejects(decode([last, 0]), { ...invalid, patch: last }, name);
    await assert.rejects(decode([0, last]), { ...invalid, patch: last }, name);
    assert.equal((await decode([0])).primitives[0].patchCount, 1, name);  // which needs nothing of the last one
  }
});
// The patches are in front of a residue, which is a Draco stream.
async function places_of_container(bytes) {
  let lengths;
  await pool.decodeUrl(new Response(bytes), { choose: ({ byteLengths }) => { lengths = byteLengths; return []; } });
  const { hasResidue } = await psplit.decodeContainer(bytes), end = hasResidue ? Buffer.from(bytes).lastIndexOf('DRACO') : bytes.length;
  let at = end - lengths.reduce((sum, length) => sum + length, 0);
  return { lengths, streams: Array.from(lengths, (length) => (at += length) - length) };
}

test('truncated and broken files', async () => {
  const below = random_numbers(5);
  for (const [name, { bytes, attributes }] of containers) {
    const chosen = ({ patchCount }) => [patchCount - 1, 0];
    const decode = async (given, choose = chosen) => {
      const { origin } = shared;
      shared.bytes = given;
      return pool.decodeUrl(`${origin}/a`, { attributes, choose });
    };
    const shared = { bytes };
    shared.origin = (await serve_ranges((path_, range) => part_of_file(shared.bytes, range))).origin;
    for (let length = 0; length < bytes.length; length += length < 100 ? 9 : Math.ceil(bytes.length / 23))
      await assert.rejects(decode(bytes.slice(0, length)), invalid, `${name}, ${length}`);
    await assert.rejects(decode(Buffer.concat([bytes, new Uint8Array(1)])), { ...invalid, message: /its length is not/ }, name);
    for (let i = 0; i < 60; ++i) {
      const broken = Uint8Array.from(bytes);
      broken[i < 30 ? below(Math.min(400, bytes.length)) : below(bytes.length)] ^= 1 << below(8);
      await decode(broken).catch((error) => assert.ok(error.name === 'PsplitError' && ['invalid-input', 'unsupported'].includes(error.code), `${name}: ${error.stack}`));
    }
  }
});

test('what choose() may return', async () => {
  const { bytes, attributes } = sample('patches'), decode = (choose, more) => pool.decodeUrl(new Response(bytes), { attributes, choose, ...more });
  for (const wrong of [[-1], [1e6], [0.5], ['0'], [0, 0], 5, [NaN], [null]]) await assert.rejects(decode(() => wrong), { ...invalid, message: /^`choose` returned/ });
  for (const wrong of [5, 'all', {}]) await assert.rejects(decode(wrong), { ...invalid, message: /is not a function/ });
  const thrown = new Error('of the caller');
  await assert.rejects(decode(() => { throw thrown; }), thrown);
  await assert.rejects(decode(() => Promise.reject(thrown)), thrown);
  await assert.rejects(decode(() => [0], { onPart: () => { throw thrown; } }), thrown);
  await assert.rejects(decode(() => new Promise(() => {}), { signal: abort_after(50) }), aborted);
  await assert.rejects(pool.decodeUrl(new Response(bytes), { choose: () => [0], attributes: [{ name: 'POSITION', uniqueId: 77, type: 'float32', componentCount: 3 }] }),
    { ...invalid, patch: 0, message: /no attribute for POSITION/ });
});

test('`signal` ends all requests at once', { ...needs_tool, timeout: 60000 }, async () => {
  const [glb] = large;
  const { origin, open, asked } = await serve_ranges((name, range) => {
    const answer = part_of_file(glb, range);
    return range[0] === 0 ? answer : { ...answer, body: in_chunks(answer.body, () => 500, 20) };
  });
  const stop = new AbortController();
  const job = pool.decodeUrl(`${origin}/a.glb`, { signal: stop.signal, choose: ({ patchCount }) => Array.from({ length: patchCount / 5 }, (_, i) => 5 * i) });
  while (asked.length < 3) await wait_ms(1);
  setTimeout(() => stop.abort(), 30);
  await assert.rejects(job, aborted);
  await wait_ms(20);  // what was on the way
  for (let left = 100; left > 0 && open.length > 0; --left) await wait_ms(2);
  assert.equal(open.length, 0);
  assert.ok(asked.length < 9);  // no more than some at a time
});

// More requests than may run at a time.
test('responses that do not end after their last byte', { ...needs_tool, timeout: 60000 }, async () => {
  const [glb] = large, chosen = (patchCount) => Array.from({ length: Math.floor(patchCount / 9) }, (_, i) => 9 * i);
  const { origin, asked } = await serve_ranges((name, range) => {
    const answer = part_of_file(glb, range);
    return { ...answer, body: endless(answer.body) };
  });
  const { primitives: [some] } = await pool.decodeUrl(`${origin}/a.glb`, { choose: ({ patchCount }) => chosen(patchCount) });
  const { primitives: [whole] } = await pool.decodeUrl(new Response(glb));
  check_chosen(some, whole, chosen(whole.patchCount));
  assert.ok(asked.length > 6, `${asked.length} requests`);
});

test('several containers, buffers beside the file, and accessors', async () => {
  const gltf = JSON.parse(readFileSync(path.join(samples, 'fallback.gltf'), 'utf8')), files = Object.fromEntries(
    gltf.buffers.map(({ uri }) => [`/${uri}`, read_sample(uri)]));
  files['/fallback.gltf'] = read_sample('fallback.gltf');
  const decode_all = async (all, name, options) =>
    pool.decodeUrl((await serve_ranges((of, range) => part_of_file(all[of], range))).origin + name, options);
  const { primitives: [own] } = await decode_all(files, '/fallback.gltf');
  const { json, primitives: [some] } = await decode_all(files, '/fallback.gltf', { choose: () => [0] });
  assert.equal(json.asset.version, '2.0');
  check_chosen(some, own, [0]);

  // A second mesh, of which all is wanted; a third one equals the first.
  const twice = structuredClone(gltf), [mesh] = twice.meshes, [primitive] = mesh.primitives;
  const copy = structuredClone(primitive), view = primitive.extensions.PSPLIT_mesh_draco_patches.bufferView;
  copy.extensions.PSPLIT_mesh_draco_patches.bufferView = twice.bufferViews.push({ ...twice.bufferViews[view] }) - 1;
  twice.meshes.push({ primitives: [copy] }, structuredClone(mesh));
  const places = [];
  const { primitives } = await decode_all({ ...files, '/twice.gltf': Buffer.from(JSON.stringify(twice)) }, '/twice.gltf',
    { choose: ({ mesh: number }) => { places.push(number); return number === 0 ? [0] : undefined; } });
  assert.deepEqual([places.sort(), primitives.map(({ mesh: number, chosen }) => [number, chosen?.length])], [[0, 1], [[0, 1], [2, 1], [1, undefined]]]);
  assert.deepEqual(primitives[2].indices, own.indices);
  assert.equal(primitives[0].indices, primitives[1].indices);

  // Accessors that do not fit are told before anything is chosen.
  ++twice.accessors[primitive.indices].count;
  await assert.rejects(decode_all({ ...files, '/twice.gltf': Buffer.from(JSON.stringify(twice)) }, '/twice.gltf', { choose: () => assert.fail() }),
    { ...invalid, mesh: 0, primitive: 0, message: /^mesh 0, primitive 0: the accessor of indices/ });
  for (const [offset, length] of [[-1, 9], [0, -1], [0.5, 9], [1e300, 9], ['x', 9]]) {
    const wrong = structuredClone(gltf);
    Object.assign(wrong.bufferViews[view], { byteOffset: offset, byteLength: length });
    await assert.rejects(decode_all({ ...files, '/wrong.gltf': Buffer.from(JSON.stringify(wrong)) }, '/wrong.gltf', { choose: () => [0] }), invalid);
  }
});

// From another origin, which exposes what its ranges are. Browsers send Range to it without asking first, but not If-Range.
const foreign = large.length === 0 ? null : await serve_ranges((name, range) => {
  const { headers, ...answer } = part_of_file(large[2], range);
  return { ...answer, headers: { ...headers, 'Access-Control-Allow-Origin': '*', 'Access-Control-Expose-Headers': 'Content-Range, ETag' } };
});
page_test('in a page', { ...needs_tool, argument: foreign?.origin, script: async (origin) => {
  const { createPool } = await import('/psplit/index.js'), pool = createPool();
  const { primitives: [some] } = await pool.decodeUrl(`${origin}/a.glb`, { choose: () => [90, 60] });
  pool.dispose();
  return [[...some.chosen], some.faceCount];
} }, async ({ result, site }) => {
  const { primitives: [{ firstFaces }] } = await pool.decodeUrl(new Response(large[2]));
  assert.deepEqual(await result, [[90, 60], firstFaces[91] - firstFaces[90] + firstFaces[61] - firstFaces[60]]);
  assert.ok(foreign.asked.length > 2 && !foreign.asked.includes(null) && foreign.sent() < large[2].length / 2);
  assert.ok(site.requests.includes('/psplit/choice.js'));
});
