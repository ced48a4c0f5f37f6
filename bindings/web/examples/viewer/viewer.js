// The page: what the controls do, and what it says about the model.
import { createPool } from './psplit/index.js';
import { compare } from './comparison.js';
import { encode_asset } from './encoding.js';
import { asset_of, on_drop, sample_asset } from './files.js';
import { load_asset } from './loading.js';
import { Stage } from './scene.js';
import { patches_of, streams_of, streams_of_glb } from './streams.js';
import { duration, number, plural, size } from './text.js';

const element = (id) => document.getElementById(id);

const stage = new Stage(element('canvas'));
let job = new AbortController();  // of the model that is loaded or measured
let current = null;               // { asset, sample, streams }
let sample = {};                  // its name and coding

function say_problem(error) {
  const is_abort = error?.code === 'aborted' || error?.name === 'AbortError';
  if (is_abort) return;
  console.warn(error);
  element('problem').textContent = error.message ?? String(error);
  element('problem').hidden = false;
  set_state('failed');
}
function set_state(state) {
  document.body.dataset.state = state;
  const is_busy = ['loading', 'encoding', 'measuring'].includes(state);
  element('progress').hidden = state !== 'loading' && state !== 'encoding';
  for (const id of ['reload', 'replay', 'measure', 'encode']) element(id).disabled = is_busy || current === null;
}
function show_progress(done, total, phase = total > 0 ? 'Decoding' : 'Loading', unit = ['patch', 'patches']) {
  element('bar').max = Math.max(1, total);
  element('bar').value = done;
  element('phase').textContent = phase;
  element('count').textContent = total > 0 ? `${number(done)} of ${plural(total, ...unit)}` : '';
}

// What the last encoding made.
function show_encoded(text, file) {
  element('encoded').textContent = text;
  if (element('save').href) URL.revokeObjectURL(element('save').href);
  element('save').removeAttribute('href');
  element('save').hidden = file === undefined;
  if (file !== undefined)
    Object.assign(element('save'), { href: URL.createObjectURL(new Blob([file.bytes], { type: 'model/gltf-binary' })), download: file.name });
}

// Encodes the model, and shows what that made in its place.
async function encode() {
  const { asset, workers } = current, { signal } = job;
  element('problem').hidden = true;
  set_state('encoding');
  show_progress(0, 0, 'Encoding');
  const pool = createPool({ workers });
  let made;
  try {
    const onProgress = (done, total) => show_progress(done, total, 'Encoding', ['triangle']);
    made = await encode_asset(asset, pool, { condense: element('condense').checked, onProgress, signal });
    signal.throwIfAborted();
  } catch (error) {
    if (signal.aborted) throw signal.reason;
    throw new Error(`${asset.name}: ${error.message ?? error}`, { cause: error });
  } finally {
    pool.dispose();
  }
  const { bytes, notes, ms } = made, name = `${asset.name.replace(/\.(glb|gltf|drc)$/i, '')}.psplit.glb`;
  const text = [`${size(asset.file_bytes)} became ${size(bytes.byteLength)}. Encoding took ${duration(ms)}.`, ...notes].join(' ');
  open_asset({ name, bytes, file_bytes: bytes.byteLength, resolve: (url) => url });
  show_encoded(text, { name, bytes });
}

// Loads an asset into the stage.
async function load(asset, of_sample = null) {
  job.abort();
  job = new AbortController();
  const { signal } = job, workers = Math.max(1, Number(element('workers').value) || 1);
  current = null;
  element('problem').hidden = true;
  element('name').textContent = asset.name;
  element('facts').replaceChildren();
  show_encoded('');
  element('times').hidden = true;
  element('compared').textContent = '';
  set_state('loading');
  show_progress(0, 0);
  const pool = createPool({ workers });
  try {
    await pool.ready();
    const { gltf, first_ms, whole_ms } = await decode(asset, pool, signal);
    const streams = await streams_of(gltf.parser.json, (view) => gltf.parser.getDependency('bufferView', view));
    signal.throwIfAborted();
    current = { asset, of_sample, streams, workers };
    show_facts(gltf, { asset, streams, first_ms, whole_ms, workers });
    set_state('shown');
  } catch (error) {
    // Another load has the stage.
    if (signal.aborted) throw signal.reason;
    stage.show(null);
    throw error.message?.startsWith(`${asset.name}:`) ? error : new Error(`${asset.name}: ${error.message ?? error}`, { cause: error });
  } finally {
    pool.dispose();
  }
  await show_times(signal);
}

async function decode(asset, pool, signal) {
  const ranges = new Map(), meshes = new Map();  // by mesh and primitive
  const key = ({ mesh, primitive }) => `${mesh} ${primitive}`;
  const onPart = ({ patches: [first], firstFaces }, use) => {
    const known = ranges.get(key(use)) ?? ranges.set(key(use), new Map()).get(key(use));
    for (let i = 0; i + 1 < firstFaces.length; ++i) known.set(first + i, [first + i, firstFaces[i], firstFaces[i + 1]]);
    for (const mesh of meshes.get(key(use)) ?? []) stage.colour(mesh, known.values());
  };
  const onProgress = (done, total) => {
    show_progress(done, total);
    stage.draw();
  };
  const begin = performance.now();
  const gltf = await load_asset(asset, { pool, signal, patchByPatch: element('growing').checked, onProgress, onPart });
  signal.throwIfAborted();
  const first_ms = performance.now() - begin;
  stage.show(gltf.scene);
  for (const mesh of stage.meshes) {
    const { meshes: number, primitives = 0 } = gltf.parser.associations.get(mesh) ?? {}, use = key({ mesh: number, primitive: primitives });
    meshes.set(use, [...(meshes.get(use) ?? []), mesh]);
    if (ranges.has(use)) stage.colour(mesh, ranges.get(use).values());
  }
  await gltf.psplit.whole;
  signal.throwIfAborted();
  const whole_ms = performance.now() - begin;
  for (const [i, mesh] of stage.meshes.entries()) colour_whole(gltf, mesh, i);
  return { gltf, first_ms, whole_ms };
}

// A patch has a colour; so has a mesh that is one Draco stream.
function colour_whole({ parser, psplit }, mesh, i) {
  const facts = psplit.patchesOf(mesh), { meshes, primitives = 0 } = parser.associations.get(mesh) ?? {};
  const is_stock = parser.json.meshes?.[meshes]?.primitives[primitives].extensions?.KHR_draco_mesh_compression !== undefined;
  if (facts !== null) {
    const { firstFaces } = facts;
    stage.colour(mesh, Array.from({ length: firstFaces.length - 1 }, (_, k) => [k, firstFaces[k], firstFaces[k + 1]]));
  } else if (is_stock) {
    stage.colour(mesh, [[i, 0, mesh.geometry.index.count / 3]]);
  }
}

function show_facts({ psplit }, { asset, streams, first_ms, whole_ms, workers }) {
  const geometries = new Map(stage.meshes.map((mesh) => [mesh.geometry, psplit.patchesOf(mesh)]));
  let triangles = 0, points = 0, decoded = 0, patches = 0, containers = 0;
  for (const [{ index, attributes }, facts] of geometries) {
    triangles += (index ?? attributes.position).count / 3;
    points += attributes.position.count;
    for (const attribute of new Set([index, ...Object.values(attributes)]))
      decoded += (attribute?.data ?? attribute)?.array.byteLength ?? 0;
    if (facts === null) continue;
    patches += facts.patchCount;
    ++containers;
  }
  const stored = streams.reduce((sum, { bytes }) => sum + bytes.length, 0), stock = streams.filter(({ kind }) => kind === 'draco').length;
  const is_condensed = [...geometries.values()].some((facts) => facts?.isCondensed);
  const rows = [
    ['Triangles', number(triangles)],
    ['Points', number(points)],
    ['Meshes', number(geometries.size)],
    containers > 0 && ['Patches', `${number(patches)}${is_condensed ? ', condensed' : ''}`],
    stock > 0 && ['Draco streams', number(stock)],
    ['File', size(asset.file_bytes)],
    stored > 0 && ['Compressed', `${size(stored)}${triangles > 0 ? `, ${number((8 * stored) / triangles, 1)} bits per triangle` : ''}`],
    ['Decoded', size(decoded)],
    element('growing').checked && containers > 0 && ['First triangles after', duration(first_ms)],
    ['Loaded after', `${duration(whole_ms)} with ${plural(workers, 'worker')}`],
  ].filter(Boolean);
  element('facts').replaceChildren(...rows.flatMap(([name, value]) => {
    const term = document.createElement('dt'), description = document.createElement('dd');
    term.textContent = name;
    description.textContent = value;
    return [term, description];
  }));
}

// The comparison in words.
function comparison_text(streams, { stock, patches }, { rounds, noise }) {
  const is_stock = streams.every(({ kind }) => kind === 'draco');
  const what = is_stock ? `Both decode the same ${streams.length === 1 ? 'Draco stream' : 'Draco streams'}.`
    : stock !== null ? 'The same mesh in two files: draco3d decodes its stock Draco, psplit also its patches, which it joins to one mesh.'
      : patches !== null ? 'draco3d decodes each patch as a mesh of its own. psplit decodes them and joins them to one mesh.'
        : 'draco3d cannot decode condensed patches, so only psplit is measured.';
  const percent = Math.round(100 * noise), kMuch = 10;
  return `${what} Median of ${rounds} runs on this machine, from bytes to arrays on the page, after one run to warm up. ` +
    `Half of them lie within ±${percent} % of it.${percent > kMuch ? ' That is much: the machine does other work, so the factors are rough.' : ''}`;
}

// Two rows of the table: the numbers, and a bar.
function time_rows({ name, what, ms, factor }, most) {
  const make = (tag, text = '', ...children) => {
    const made = document.createElement(tag);
    made.append(text, ...children);
    return made;
  };
  const head = Object.assign(make('th', `${name} `, make('span', what)), { scope: 'row' });
  const bar = Object.assign(make('td'), { colSpan: 3,
    innerHTML: `<svg viewBox="0 0 100 1" preserveAspectRatio="none"><rect height="1" width="${(100 * ms) / most}"/></svg>` });
  const bars = make('tr', bar);
  bars.className = name === 'psplit' ? 'ours' : '';
  bars.ariaHidden = 'true';
  const over = factor === undefined ? '' : `${number(factor, factor === 1 ? 0 : 1)} ×`;
  return [make('tr', head, make('td', duration(ms)), make('td', over)), bars];
}

async function show_times(signal) {
  const { streams, of_sample, workers } = current;
  if (streams.length === 0) {
    element('compared').textContent = 'The model has no Draco streams and no patches, so there is nothing to measure.';
    return set_state('measured');
  }
  set_state('measuring');
  element('compared').textContent = 'Measuring …';
  const is_stock = streams.every(({ kind }) => kind === 'draco');
  const stock = of_sample === null || is_stock ? null
    : await streams_of_glb((await sample_asset({ ...of_sample, coding: 'draco' }, signal)).bytes);
  const apart = streams.map((stream) => (stream.kind === 'draco' ? [stream] : patches_of(stream)));
  const others = { stock, patches: is_stock || apart.includes(null) ? null : apart.flat() };
  let compared;
  try {
    compared = await compare(streams, { ...others, workers }, signal);
  } catch (error) {
    signal.throwIfAborted();
    element('compared').textContent = `The decoders cannot be compared: ${error.message}`;
    return set_state('measured');
  }
  const { rows } = compared;
  const most = Math.max(...rows.map(({ ms }) => ms));
  element('times').tBodies[0].replaceChildren(...rows.flatMap((row) => time_rows(row, most)));
  element('times').hidden = false;
  element('compared').textContent = comparison_text(streams, others, compared);
  set_state('measured');
}

// The controls

function press(group, attribute, value) {
  for (const button of element(group).querySelectorAll('button'))
    button.setAttribute('aria-pressed', String(button.dataset[attribute] === value));
}
async function open_sample(change) {
  sample = { ...sample, ...change };
  press('samples', 'sample', sample.name);
  press('codings', 'coding', sample.coding);
  history.replaceState(null, '', `#${sample.name}.${sample.coding}`);
  for (const button of element('codings').children) button.disabled = false;
  try {
    await load(await sample_asset(sample, job.signal), sample);
  } catch (error) {
    say_problem(error);
  }
}
// An asset that is no sample.
async function open_asset(asset) {
  try {
    press('samples', 'sample', null);
    press('codings', 'coding', null);
    sample = { coding: 'patches' };
    history.replaceState(null, '', location.pathname);
    for (const button of element('codings').children) button.disabled = true;
    await load(asset);
  } catch (error) {
    say_problem(error);
  }
}
const open_files = (files) => asset_of(files).then(open_asset).catch(say_problem);

element('samples').addEventListener('click', ({ target }) => target.dataset.sample && open_sample({ name: target.dataset.sample }));
element('codings').addEventListener('click', ({ target }) => target.dataset.coding && open_sample({ coding: target.dataset.coding }));
element('files').addEventListener('change', ({ target }) => target.files.length > 0 && open_files([...target.files]));
element('colours').addEventListener('change', ({ target }) => (stage.has_colours = target.checked));
element('reload').addEventListener('click', () => load(current.asset, current.of_sample).catch(say_problem));
element('encode').addEventListener('click', () => encode().catch(say_problem));
element('measure').addEventListener('click', () => show_times(job.signal).catch(say_problem));
element('replay').addEventListener('click', () => {
  const begin = performance.now(), kMs = 2500;
  const step = (now) => {
    stage.part = (now - begin) / kMs;
    if (now - begin < kMs) requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
});
element('theme').addEventListener('click', () => {
  const is_dark = getComputedStyle(document.documentElement).colorScheme === 'dark' ||
    (document.documentElement.dataset.theme === undefined && matchMedia('(prefers-color-scheme: dark)').matches);
  document.documentElement.dataset.theme = is_dark ? 'light' : 'dark';
});

on_drop(element('drop'), open_files);

element('workers').value = Math.max(1, Math.min(4, navigator.hardwareConcurrency ?? 4));
element('workers').max = navigator.hardwareConcurrency ?? 16;
// An address such as #terrain.condensed opens that sample.
const [, name = 'blob', coding = 'patches'] = /^#(\w+)\.(\w+)$/.exec(location.hash) ?? [];
open_sample({ name, coding });
