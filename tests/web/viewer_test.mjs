// The viewer in Chromium, under its own policy: it shows samples and dropped files, with their numbers. Its page with two sides shows the
// same file by WebAssembly and by WebGPU, whose pictures are equal.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test, { after, before } from 'node:test';
import { kMostMs, need_browser, open_page, skip as no_chromium } from './browser.mjs';
import { fallback_files, gltf_psplit, root, with_asset } from './load.mjs';
import { encode, encode_cloud, grid } from './stock_draco.mjs';

const viewer = path.join(root, 'bindings/web/examples/viewer'), samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const pictures = path.join(root, 'build/web/pictures');
const skip = no_chromium || (gltf_psplit === null && 'there is no gltf-psplit');
const { server } = await import(path.join(viewer, 'serve.mjs'));

need_browser();
before(async () => {
  if (skip !== false) return;
  execFileSync(path.join(viewer, 'build'), { env: { ...process.env, PSPLIT: gltf_psplit }, stdio: ['ignore', 'ignore', 'inherit'] });
  mkdirSync(pictures, { recursive: true });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
});
after(() => {
  server.close();
  server.closeAllConnections();
});

// Opens a page of the viewer; prepare(page) is called before.
async function with_viewer(address, use, prepare = () => {}) {
  const opened = await open_page('about:blank'), { page } = opened;
  try {
    await page.setViewport({ width: 1280, height: 800 });
    await prepare(page);
    await page.goto(`http://127.0.0.1:${server.address().port}/${address}`, { waitUntil: 'domcontentloaded', timeout: kMostMs });
    await use({ ...opened, state: state_of(page) });
  } finally {
    await opened.close();
  }
}

// What the page says when it is done.
const state_of = (page) => async () => {
  await page.waitForFunction(() => ['measured', 'failed'].includes(document.body.dataset.state), { timeout: 100000, polling: 100 });
  return page.evaluate(() => {
    const lines = (id) => document.getElementById(id).innerText.split('\n').map((line) => line.trim()).filter((line) => line !== '');
    const facts = lines('facts');
    return { state: document.body.dataset.state, name: document.getElementById('name').innerText, times: lines('times'), compared: lines('compared').join(' '), problem: lines('problem').join(' '),
      facts: Object.fromEntries(facts.flatMap((line, i) => (i % 2 === 0 ? [[line, facts[i + 1]]] : []))) };
  });
};

// Drops files of the samples on the page.
const drop = (page, names, change = (bytes) => bytes) =>
  drop_bytes(page, Object.fromEntries(names.map((name) => [name, change(readFileSync(path.join(samples, name)))])));
async function drop_bytes(page, contents) {
  const files = Object.entries(contents).map(([name, bytes]) => ({ name, data: Buffer.from(bytes).toString('base64') }));
  await page.evaluate((given) => {
    document.body.dataset.state = 'dropped';
    const dataTransfer = new DataTransfer();
    for (const { name, data } of given) dataTransfer.items.add(new File([Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0))], name));
    window.dispatchEvent(new DragEvent('drop', { dataTransfer }));
  }, files);
}

// The number of colours in a picture of the canvas, and how much of it the model covers.
async function picture(page, name) {
  const { x, y, width, height } = await (await page.$('#stage')).boundingBox();
  const data = await page.screenshot({ path: path.join(pictures, `${name}.png`), clip: { x, y, width, height }, encoding: 'base64' });
  await page.screenshot({ path: path.join(pictures, `${name}-page.png`) });
  return page.evaluate(async (base64) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data: pixels } = context.getImageData(0, 0, bitmap.width, bitmap.height), hues = new Set();
    let covered = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      const [r, g, b] = pixels.subarray(i, i + 3), most = Math.max(r, g, b), range = most - Math.min(r, g, b);
      if (range < 60) continue;  // the ground is grey
      ++covered;
      const hue = most === r ? (g - b) / range : most === g ? 2 + (b - r) / range : 4 + (r - g) / range;
      hues.add(Math.floor((hue + 6) % 6));
    }
    return { hues: hues.size, covered: covered / (pixels.length / 4) };
  }, data);
}

test('a sample', { skip, timeout: 120000 }, () => with_viewer('#scene.patches', async ({ page, errors, state }) => {
  const { state: last, facts, times, compared } = await state();
  assert.equal(last, 'measured');
  assert.match(facts.Triangles, /^\d{3},\d{3}$/);
  assert.ok(Number(facts.Patches) > 20);
  for (const name of ['Points', 'Meshes', 'File', 'Compressed', 'Decoded', 'First triangles after', 'Loaded after']) assert.match(facts[name], /\d/, name);
  assert.ok(times.some((line) => /draco3d.*stock Draco/.test(line)) && times.some((line) => /psplit.*patches joined/.test(line)), `${times}`);
  assert.match(compared, /same mesh in two files.*Median of \d+ runs.*Half of them lie within ±\d+ % of it/);
  const coloured = await picture(page, 'scene');
  assert.ok(coloured.hues >= 5 && coloured.covered > 0.05, JSON.stringify(coloured));
  await page.click('#colours');
  await new Promise((resolve) => setTimeout(resolve, 500));
  assert.ok((await picture(page, 'scene-plain')).covered < coloured.covered / 2);
  assert.deepEqual(errors, []);
}));

test('dropped files', { skip, timeout: 120000 }, () => with_viewer('#scene.draco', async ({ page, errors, state }) => {
  const stock = await state();
  assert.ok(Number(stock.facts['Draco streams']) > 3);
  assert.match(stock.compared, /^Both decode the same Draco streams/);
  await drop(page, ['seams.glb']);
  const seams = await state();
  assert.deepEqual([seams.state, seams.facts.Triangles, seams.facts.Points], ['measured', '592', '396']);
  assert.match(seams.compared, /^draco3d decodes each patch as a mesh of its own/);
  assert.ok((await picture(page, 'seams')).covered > 0.1);
  await drop(page, fallback_files);
  const fallback = await state();
  assert.deepEqual([fallback.state, fallback.facts.Triangles], ['measured', '304']);
  await drop(page, ['condensed.glb']);
  assert.match((await state()).compared, /^draco3d cannot decode condensed patches/);
  assert.deepEqual(errors, []);
  await drop(page, ['patches.glb'], (bytes) => bytes.fill(0xff, bytes.length - 60));
  const { state: last, problem } = await state();
  assert.equal(last, 'failed');
  assert.match(problem, /^patches\.glb: mesh 0 "terrain", primitive 0: patch \d: /);
}));

test('dropped Draco streams', { skip, timeout: 120000 }, () => with_viewer('#scene.draco', async ({ page, errors, state }) => {
  await state();
  const { points, faces } = grid(40);
  for (const extra of [false, true]) {
    await drop_bytes(page, { 'grid.drc': encode({ points, faces }, { method: 'edgebreaker', speed: 5, bits: 11, extra }) });
    const { state: last, name, facts, compared } = await state();
    assert.deepEqual([last, name, facts.Triangles, facts['Draco streams']], ['measured', 'grid.drc', faces.length.toLocaleString('en'), '1']);
    assert.match(compared, /^Both decode the same Draco stream\./);
    assert.ok((await picture(page, 'grid')).covered > 0.1);
  }
  assert.deepEqual(errors, []);
  await drop_bytes(page, { 'cloud.drc': encode_cloud(100) });
  const { state: last, problem } = await state();
  assert.equal(last, 'failed');
  assert.match(problem, /^cloud\.drc: .*not a Draco mesh/);
}));

// Encodes the shown model. Returns the file that the page offers, and the page's text.
async function encode_shown(page, state, name) {
  await page.evaluate(() => {
    document.body.dataset.state = 'asked';
    document.getElementById('encode').click();
  });
  const shown = await state();
  const { text, file, data } = await page.evaluate(async () => {
    const link = document.getElementById('save'), bytes = link.hidden ? [] : new Uint8Array(await (await fetch(link.href)).arrayBuffer());
    return { text: document.getElementById('encoded').innerText, file: link.download, data: Array.from(bytes, (byte) => String.fromCharCode(byte)).join('') };
  });
  const saved = path.join(pictures, name);
  writeFileSync(saved, Buffer.from(data, 'latin1'));
  return { ...shown, text, file, saved };
}

test('what is shown becomes patches', { skip, timeout: 120000 }, () => with_viewer('#scene.draco', async ({ page, errors, state }) => {
  const stock = await state();
  const made = await encode_shown(page, state, 'encoded.glb');
  assert.deepEqual([made.state, made.problem, made.name, made.file], ['measured', '', 'scene.draco.psplit.glb', 'scene.draco.psplit.glb']);
  assert.equal(made.facts.Triangles, stock.facts.Triangles);
  assert.ok(Number(made.facts.Patches) > 5 && made.facts['Draco streams'] === undefined, JSON.stringify(made.facts));
  assert.match(made.text, /^[\d.]+ kB became [\d.]+ kB\. Encoding took [\d,.]+ ms\.$/);
  execFileSync(gltf_psplit, ['validate', '-q', made.saved]);
  const coloured = await picture(page, 'encoded');
  assert.ok(coloured.hues >= 4 && coloured.covered > 0.05, JSON.stringify(coloured));
  // A .gltf with files, condensed.
  await drop(page, fallback_files);
  await state();
  await page.click('#condense');
  const other = await encode_shown(page, state, 'encoded_condensed.glb');
  assert.deepEqual([other.state, other.file, other.facts.Triangles], ['measured', 'fallback.psplit.glb', '304']);
  execFileSync(gltf_psplit, ['validate', '-q', other.saved]);
  assert.deepEqual(errors, []);
}));

test('files that cannot be shown', { skip, timeout: 120000 }, () => with_viewer('#scene.draco', async ({ page, state }) => {
  const before = await state();
  // Nothing to load: the model stays, with its name and its facts.
  await drop(page, ['README.md']);
  const other = await state();
  assert.deepEqual([other.state, other.problem, other.name, other.facts],
    ['failed', 'README.md: not a .glb, .gltf or .drc', before.name, before.facts]);
  assert.ok((await picture(page, 'kept')).covered > 0.05);
  // A model that fails: none is shown under its name.
  for (const bytes of [[1, 2, 3], Buffer.from('{"asset":{"version":"2.0"},"buffers":[{"uri":"missing.bin","byteLength":8}],' +
    '"bufferViews":[{"buffer":0,"byteLength":8}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":0}],' +
    '"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}')]) {
    await drop_bytes(page, { 'broken.gltf': bytes });
    const { state: last, problem, name, facts } = await state();
    assert.deepEqual([last, name, facts], ['failed', 'broken.gltf', {}]);
    assert.match(problem, /^broken\.gltf: ./);
    assert.ok((await picture(page, 'broken')).covered < 0.01);  // the message has a colour
  }
}));

// The page with two sides.
const kMostMsOfSides = 150000, glb = skip ? null : with_asset(1500, ['--patch-faces', '300'], (file) => readFileSync(file));

// What the page says of a dropped file: its notices, and its tables as rows of texts; and the colours of each picture.
async function shown(page, name, bytes) {
  await page.waitForFunction(() => document.body.dataset.state === 'shown');
  await drop_bytes(page, { [name]: bytes });
  await page.waitForFunction(() => ['shown', 'failed'].includes(document.body.dataset.state), { timeout: kMostMsOfSides, polling: 100 });
  await page.screenshot({ path: path.join(pictures, `side-by-side-${name}.png`), fullPage: true });
  return page.evaluate(() => {
    const text = (id) => document.getElementById(id).innerText, rows = (id) => [...document.getElementById(id).rows].map(({ cells }) => [...cells].map(({ innerText }) => innerText));
    const canvases = [...document.querySelectorAll('canvas')].filter((canvas) => canvas.checkVisibility());
    return { state: document.body.dataset.state, problem: text('problem'), webgpu: text('webgpu'), pictures: text('pictures'), costs: rows('costs'), meshes: rows('meshes'),
      colours: canvases.map((canvas) => new Set(new Uint32Array(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size) };
  });
}
const kNumber = /^[\d,.]+ (ms|kB|MB)/;

test('CPU and GPU side by side', { skip, timeout: kMostMsOfSides }, () => with_viewer('side_by_side.html#none', async ({ page, errors }) => {
  const { state, problem, webgpu, pictures: text, costs, meshes, colours } = await shown(page, 'patches.glb', glb);
  assert.deepEqual([state, problem], ['shown', '']);
  assert.match(webgpu, /processor computes WebGPU.*say nothing about a GPU/);
  assert.equal(text, 'Both pictures are equal, in every pixel.');
  assert.ok(colours.length === 2 && colours.every((count) => count > 50), `${colours}`);
  const [heads, ...rows] = costs, by_name = Object.fromEntries(rows.map(([name, ...values]) => [name.replace(/,? at most .*/, ''), values]));
  assert.deepEqual(heads, ['', 'CPU', 'GPU']);
  for (const name of ['First frame, first load', 'First frame, second load', 'Main thread blocked, first load', 'Main thread blocked, second load', 'Buffers on the GPU'])
    for (const value of by_name[name]) assert.match(value, kNumber, name);
  for (const name of ['Memory of WebAssembly', 'Arrays of the meshes in JavaScript']) {
    assert.match(by_name[name][0], kNumber, name);
    assert.equal(by_name[name][1], 'none', name);
  }
  const [heads_of_meshes, [, triangles, ...others], ...more] = meshes;
  assert.deepEqual([heads_of_meshes, others, more], [['Mesh', 'Triangles', 'Patches', 'CPU', 'GPU'], ['5', 'WebAssembly', 'shaders'], []]);
  assert.match(triangles, /^1,[345]\d\d$/);
  // Both turn.
  const data_of = () => page.evaluate(() => document.getElementById('cpu').toDataURL()), before = await data_of();
  await page.focus('#gpu');
  for (let i = 0; i < 3; ++i) await page.keyboard.press('ArrowLeft');
  await page.waitForFunction(() => document.body.dataset.state === 'shown');
  assert.notEqual(await data_of(), before);
  assert.equal(await page.evaluate(() => document.getElementById('pictures').innerText), text);
  assert.deepEqual(errors, []);
}));

test('the CPU alone, without WebGPU', { skip, timeout: kMostMsOfSides }, () => with_viewer('side_by_side.html#none', async ({ page, errors }) => {
  const { state, webgpu, pictures: text, costs, meshes, colours } = await shown(page, 'no-webgpu.glb', glb);
  assert.deepEqual([state, webgpu, text], ['shown', 'This browser has no WebGPU, so only the CPU is shown.', '']);
  assert.ok(colours.length === 1 && colours[0] > 50, `${colours}`);
  assert.deepEqual(costs[0], ['', 'CPU']);
  assert.deepEqual(costs.at(-1), ['Buffers on the GPU', 'not known']);
  assert.equal(meshes[1].at(-1), 'WebAssembly');
  const broken = await shown(page, 'broken.glb', glb.subarray(0, 400));
  assert.equal(broken.state, 'failed');
  assert.match(broken.problem, /^broken\.glb: ./);
  assert.deepEqual(errors, []);
}, (page) => page.evaluateOnNewDocument(() => Object.defineProperty(Navigator.prototype, 'gpu', { get: () => undefined }))));
