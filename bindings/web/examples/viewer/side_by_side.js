// The page: loads a model by WebAssembly and by WebGPU, in turn, and says what both took.
import { asset_of, on_drop, sample_asset } from './files.js';
import { Side } from './side.js';
import { duration, number, plural, size } from './text.js';

const element = (id) => document.getElementById(id);
const workers = Math.max(1, Math.min(4, navigator.hardwareConcurrency ?? 4));
let sides = [], direction = [0.5, 0.42], job = new AbortController(), shown = null;

// Returns a WebGPU adapter, or the reason why the browser gives none.
async function find_webgpu() {
  if (navigator.gpu === undefined)
    return { why: isSecureContext ? 'This browser has no WebGPU, so only the CPU is shown.' : 'Browsers offer WebGPU to pages of https and of localhost alone, so only the CPU is shown.' };
  const adapter = await navigator.gpu.requestAdapter().catch(() => null);
  return adapter === null ? { why: 'This browser finds no GPU for WebGPU, so only the CPU is shown.' } : { adapter };
}
const { adapter, why } = await find_webgpu(), has_webgpu = adapter !== undefined;
const name_of = ({ info }) => [info?.vendor, info?.architecture, info?.device, info?.description].filter(Boolean).join(', ') || 'unnamed';
const is_software = has_webgpu && (adapter.info?.isFallbackAdapter === true || /swiftshader|llvmpipe|lavapipe|software/i.test(name_of(adapter)));
element('webgpu').hidden = has_webgpu && !is_software;
element('webgpu').textContent = why ?? `The processor computes WebGPU here (${name_of(adapter)}): pictures are right, but times say nothing about a GPU.`;
element('gpu').parentElement.hidden = !has_webgpu;

function set_state(state, problem) {
  document.body.dataset.state = state;
  element('again').disabled = state === 'loading' || shown === null;
  element('problem').hidden = problem === undefined;
  element('problem').textContent = problem ?? '';
}

function fill(id, rows) {
  element(id).replaceChildren(...rows.map((row, r) => {
    const line = document.createElement('tr');
    line.append(...row.map((text, i) => (r === 0 || i === 0
      ? Object.assign(document.createElement('th'), { textContent: text, scope: r === 0 ? 'col' : 'row' })
      : Object.assign(document.createElement('td'), { textContent: text }))));
    return line;
  }));
}

const size_or_none = (bytes) => (bytes === 0 ? 'none' : bytes && size(bytes));
const heads = has_webgpu ? ['CPU', 'GPU'] : ['CPU'];
function show_costs(results) {
  const row = (name, of) => [name, ...results.map((result) => of(result) ?? 'not known')];
  const blocked = ({ blocked: all, longest }) => `${duration(all)}${longest > 0 && longest < all ? `, at most ${duration(longest)} at once` : ''}`;
  fill('costs', [['', ...heads],
    row('First frame, first load', ({ loads }) => duration(loads[0].frame_ms)),
    row('First frame, second load', ({ loads }) => duration(loads[1].frame_ms)),
    row('Main thread blocked, first load', ({ loads }) => blocked(loads[0])),
    row('Main thread blocked, second load', ({ loads }) => blocked(loads[1])),
    row(`Memory of WebAssembly, at most ${plural(workers, 'worker')}`, ({ memory: { wasm } }) => size_or_none(wasm)),
    row('Arrays of the meshes in JavaScript', ({ memory: { arrays } }) => size_or_none(arrays)),
    row('Buffers on the GPU', ({ memory: { buffers, most_buffers } }) => (buffers === undefined ? undefined : `${size(buffers)}, at most ${size(most_buffers)} while loading`))]);
}

function way_of({ patches }) {
  if (patches === null) return 'not in patches';
  return patches.way === 'gpu' ? 'shaders' : `WebAssembly${patches.why === undefined ? '' : `: ${patches.why}`}`;
}
function show_meshes() {
  const kMost = 50, meshes = sides[0].meshes, rows = meshes.slice(0, kMost).map(({ name, triangles, patches }, i) =>
    [name || `mesh ${i}`, number(triangles), patches === null ? '' : number(patches.patchCount), ...sides.map((side) => way_of(side.meshes[i]))]);
  if (meshes.length > kMost) rows.push([`and ${plural(meshes.length - kMost, 'mesh', 'meshes')} more`]);
  fill('meshes', [['Mesh', 'Triangles', 'Patches', ...heads], ...rows]);
}

// Whether both pictures are the same.
function show_pictures() {
  if (sides.length < 2) return (element('pictures').textContent = '');
  const [a, b] = sides.map(({ pixels }) => new Uint32Array(pixels.buffer)), count = a.reduce((sum, pixel, i) => sum + (pixel === b[i] ? 0 : 1), 0);
  element('pictures').textContent = count === 0 ? 'Both pictures are equal, in every pixel.' : `The pictures differ in ${plural(count, 'pixel')}.`;
}

async function load(asset) {
  job.abort();
  job = new AbortController();
  const { signal } = job, drawn = direction;
  shown = null;
  element('name').textContent = asset.name;
  for (const id of ['costs', 'meshes']) fill(id, []);
  for (const id of ['cpu', 'gpu']) element(id).getContext('2d').reset();
  set_state('loading');
  for (const side of sides) side.dispose();
  sides = [];
  const made = [], results = [];
  try {
    for (const is_on_gpu of has_webgpu ? [false, true] : [false]) {
      element('pictures').textContent = `Loading by ${is_on_gpu ? 'WebGPU' : 'WebAssembly'} …`;
      const side = await Side.make(element(is_on_gpu ? 'gpu' : 'cpu'), { is_on_gpu, has_webgpu, signal }), loads = [];
      made.push(side);
      for (let i = 0; i < 2; ++i) loads.push(await side.load(asset, { workers, direction: drawn, signal }));
      results.push({ loads, memory: await side.memory() });
      signal.throwIfAborted();
    }
  } catch (error) {
    for (const side of made) side.dispose();
    if (signal.aborted) return;
    console.warn(error);
    element('pictures').textContent = '';
    return set_state('failed', error.message?.startsWith(`${asset.name}:`) ? error.message : `${asset.name}: ${error.message ?? error}`);
  }
  sides = made;
  shown = asset;
  show_costs(results);
  show_meshes();
  show_pictures();
  set_state('shown');
  if (direction !== drawn) turn(0, 0);
}

const fail = (error) => set_state('failed', error.message ?? String(error));
// The last file that is opened is shown, even if an earlier one arrives later.
let opening = new AbortController();
function open(make_asset) {
  opening.abort();
  job.abort();
  const { signal } = (opening = new AbortController());
  make_asset(signal).then((asset) => signal.aborted || load(asset)).catch((error) => signal.aborted || fail(error));
}
const open_files = (files) => open(() => asset_of(files));
const open_sample = (name) => open((signal) => sample_asset({ name, coding: 'patches' }, signal));

element('samples').addEventListener('click', ({ target }) => target.dataset.sample && open_sample(target.dataset.sample));
element('files').addEventListener('change', ({ target }) => target.files.length > 0 && open_files([...target.files]));
element('again').addEventListener('click', () => load(shown));
on_drop(element('drop'), open_files);

// Both sides are drawn from one direction, at last from the latest.
let is_drawing = false;
async function turn(x, y) {
  const kMostPitch = 1.5, now = sides;
  direction = [direction[0] - x / 150, Math.max(-kMostPitch, Math.min(kMostPitch, direction[1] + y / 150))];
  if (is_drawing || sides.length === 0) return;
  is_drawing = true;
  document.body.dataset.state = 'turning';
  try {
    for (let drawn = null; drawn !== direction && sides === now;) {
      drawn = direction;
      for (const side of now) await side.draw(drawn);
    }
    if (sides === now) show_pictures(), set_state('shown');
  } catch (error) {
    if (sides === now) fail(error);  // or another model is loaded
  } finally {
    is_drawing = false;
  }
}
const kTurns = { ArrowLeft: [15, 0], ArrowRight: [-15, 0], ArrowUp: [0, -15], ArrowDown: [0, 15] };
for (const id of ['cpu', 'gpu']) {
  element(id).addEventListener('pointermove', ({ buttons, movementX, movementY }) => buttons > 0 && turn(movementX, movementY));
  element(id).addEventListener('keydown', (event) => {
    if (!(event.key in kTurns)) return;
    event.preventDefault();
    turn(...kTurns[event.key]);
  });
}

// An address such as #terrain opens that sample, or none.
const name = location.hash.slice(1) || 'scene';
if (name === 'none') element('pictures').textContent = 'Choose a sample, or open a file.', set_state('shown');
else open_sample(name);
