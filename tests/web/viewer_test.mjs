// The viewer in Chromium, under its own policy: it shows samples and dropped files, with their numbers.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after, before } from 'node:test';
import { close_browser, open_page, skip as no_chromium } from './browser.mjs';
import { gltf_psplit, root } from './load.mjs';

const viewer = path.join(root, 'web/examples/viewer'), samples = path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples');
const pictures = path.join(root, 'build/web/pictures');
const skip = no_chromium || (gltf_psplit === null && 'there is no gltf-psplit');
const { server } = await import(path.join(viewer, 'serve.mjs'));

before(async () => {
  if (skip !== false) return;
  execFileSync(path.join(viewer, 'build'), { env: { ...process.env, PSPLIT: gltf_psplit }, stdio: ['ignore', 'ignore', 'inherit'] });
  mkdirSync(pictures, { recursive: true });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
});
after(async () => {
  await close_browser();
  server.close();
  server.closeAllConnections();
});

async function with_viewer(hash, use) {
  const opened = await open_page('about:blank'), { page } = opened;
  try {
    await page.setViewport({ width: 1280, height: 800 });
    await page.goto(`http://127.0.0.1:${server.address().port}/${hash}`, { waitUntil: 'domcontentloaded' });
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
    return { state: document.body.dataset.state, times: lines('times'), compared: lines('compared').join(' '), problem: lines('problem').join(' '),
      facts: Object.fromEntries(facts.flatMap((line, i) => (i % 2 === 0 ? [[line, facts[i + 1]]] : []))) };
  });
};

// Drops files of the samples on the page.
async function drop(page, names, change = (bytes) => bytes) {
  const files = names.map((name) => ({ name, data: change(readFileSync(path.join(samples, name))).toString('base64') }));
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
  assert.match(compared, /same mesh in two files.*Median of \d+ runs/);
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
  await drop(page, ['fallback.3017754ff5302130.bin', 'fallback.gltf', 'fallback.96bccec7e0ab550e.bin']);
  const fallback = await state();
  assert.deepEqual([fallback.state, fallback.facts.Triangles], ['measured', '304']);
  await drop(page, ['condensed.glb']);
  assert.match((await state()).compared, /^draco3d cannot decode condensed patches/);
  assert.deepEqual(errors, []);
  await drop(page, ['patches.glb'], (bytes) => bytes.fill(0xff, bytes.length - 60));
  const { state: last, problem } = await state();
  assert.equal(last, 'failed');
  assert.match(problem, /^patches\.glb: mesh 0 "terrain", primitive 0: patch \d: /);
  await drop(page, ['README.md']);
  assert.match((await state()).problem, /no \.glb or \.gltf/);
}));
