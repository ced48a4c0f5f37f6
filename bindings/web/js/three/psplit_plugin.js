// The extension PSPLIT_mesh_draco_patches for three's GLTFLoader. Before the loader reads accessors, each primitive of the
// extension gets synthetic accessors and buffer views, whose bytes are the arrays of the decoded mesh. So the loader works as
// for an asset that is not compressed.
import { PsplitError } from '../error.js';
import { kDraco, kExtensionName, use_fine_meshes } from '../gltf.js';
import { createPool } from '../pool.js';
import { Container, kOfDeformed } from './container.js';
import { PsplitDracoLoader } from './draco_loader.js';
import { GrowingMesh } from '../growing_mesh.js';
import { StockDraco } from './stock_draco.js';

let default_pool;
// Assets whose JSON does not say that they use Draco, until a plugin takes care of it. Of several plugins, a loader asks the last.
const hides_draco = new WeakSet();

// Of bytes that are fetched. Rejects when the signal aborts, also if the promise never settles.
const until_abort = (promise, signal) => new Promise((resolve, reject) => {
  const abort = () => reject(new PsplitError('aborted', 'aborted'));
  if (signal.aborted) abort();
  signal.addEventListener('abort', abort);
  promise.then(resolve, (error) => reject(new PsplitError(error.message ?? String(error), 'failed')));
});

// A promise that make() returns when it is needed first.
function lazily(make) {
  let made;
  return { then: (...use) => (made ??= make()).then(...use) };
}

// A loader may read the fallback in place of a container that it cannot decode, except if the container is invalid.
const may_fall_back = ({ code }) => code === 'failed' || code === 'unsupported' || code === 'out-of-memory';

export class PsplitPlugin {
  name = kExtensionName;
  #parser;
  #options;
  #asset;  // an ArrivingAsset, if the bytes arrive
  #pool;
  #containers = new Map();  // by key
  #of_view = new Map();     // containers by their synthetic buffer views
  #growing = [];            // promises of meshes that are shown patch by patch
  #running = new Set();     // the AbortControllers of containers that are being decoded
  #failure = null;          // the first one
  #turn = null;       // while the loader requests the parts of a mesh: resolves when the meshes before it are made
  #next_turn = null;  // resolves when the meshes before the next mesh are made
  #stop = () => this.#running.forEach((controller) => controller.abort());

  constructor(parser, options) {
    this.#parser = parser;
    this.#options = options ?? {};
    this.#asset = this.#options.asset;
    this.#pool = this.#options.pool ?? (default_pool ??= createPool());
    // A loader without a DRACOLoader refuses assets that use this extension, before it asks a plugin.
    const { json } = parser;
    if (this.#options.dracoLoader === false || !json.extensionsUsed?.includes(kDraco)) return;
    json.extensionsUsed = json.extensionsUsed.filter((name) => name !== kDraco);
    hides_draco.add(json);
  }

  // The hooks of GLTFLoader. A function that is `async` rejects where it would throw, which the loader handles.

  async beforeRoot() {
    use_fine_meshes(this.#parser.json);
    if (hides_draco.delete(this.#parser.json)) this.#take_draco();
    for (const i of this.#asset === undefined ? [] : this.#parser.json.buffers?.keys() ?? [])
      this.#parser.cache.add(`buffer:${i}`, { then: (...use) => this.#asset.buffer(i).then(({ buffer }) => buffer).then(...use) });
    for (const [mesh, { primitives }] of (this.#parser.json.meshes ?? []).entries())
      for (const [primitive, definition] of primitives.entries())
        if (definition.extensions?.[kExtensionName] !== undefined) this.#replace_accessors(definition, { mesh, primitive });
    // Renderers know the bounds of rigid meshes, and need not read their points.
    const { gpu, choose } = this.#options, all = [...this.#containers.values()], of_gpu = all.filter(({ is_rigid }) => gpu != null && choose == null && is_rigid);
    for (const container of gpu == null ? [] : all) {
      if (of_gpu.includes(container)) this.#take_accessors(container);
      else container.why = choose == null ? 'a mesh that is skinned or has morph targets' : 'chosen patches';
    }
    this.#pool.begin?.(all.length - of_gpu.length);
  }

  #take_draco() {
    const { json, extensions, options: { manager } } = this.#parser, { dracoLoader } = this.#options;
    json.extensionsUsed.push(kDraco);
    extensions[kDraco] = new StockDraco(dracoLoader ?? new PsplitDracoLoader({ manager, pool: this.#pool }), (error, definition) => {
      const mesh = json.meshes.findIndex(({ primitives }) => primitives.includes(definition));
      const use = { mesh, primitive: json.meshes[mesh].primitives.indexOf(definition) };
      return this.#error_at(use, definition.extensions[kDraco].bufferView, error);
    }, (decoded) => this.#in_turn(decoded));
  }

  // The accessors of a container become attributes that the GPU has, or of the decoded arrays if the GPU does not decode it.
  #take_accessors(container) {
    const on_gpu = lazily(() => this.#in_turn(this.#run(container, (signal) => this.#decode_on_gpu(container, signal))));
    container.columns.forEach(({ number }, i) => this.#parser.cache.add(`accessor:${number}`,
      lazily(() => on_gpu.then((attributes) => attributes?.[i] ?? this.#parser.loadAccessor(number)))));
  }

  // Meshes and their materials are made in the order in which the loader asks for them. three draws opaque meshes in the order of their
  // materials' numbers, so the picture and its time do not depend on which mesh is decoded first.
  loadMesh(mesh) {
    const before = (this.#turn = this.#next_turn), made = Promise.resolve().then(() => {
      this.#turn = null;  // later requests must not wait: an earlier mesh may need them
      return this.#parser.getDependency('mesh', mesh);
    });
    this.#next_turn = Promise.allSettled([before, made]);
    return null;  // the loader itself makes it
  }
  // A material that the mesh is the first to have, too.
  async extendMaterialParams() {
    await this.#turn;
  }
  // Settles as `promise` does, but not before the turn of the mesh that GLTFLoader asks for now.
  async #in_turn(promise) {
    const turn = this.#turn, result = await promise;
    await turn;
    return result;
  }

  loadBufferView(view) {
    const container = this.#of_view.get(view);
    if (container === undefined) return this.#arriving_view(view);
    container.buffers ??= this.#in_turn(this.#load(container));
    return container.buffers.then((buffers) => buffers.get(view));
  }

  // The bytes of a buffer view without extensions, as they arrive; null leaves other views to their extensions.
  #arriving_view(view) {
    if (this.#asset === undefined || this.#parser.json.bufferViews[view].extensions !== undefined) return null;
    return this.#asset.view(view).then(({ buffer }) => buffer);
  }

  afterRoot(gltf) {
    gltf.psplit = this;
  }

  // The members that users call:

  get whole() {
    const whole = Promise.all(this.#growing).then(() => {});
    whole.catch(() => {});  // nothing happens if the caller does not wait
    return whole;
  }

  patchesOf(object) {
    const { meshes, primitives = 0 } = this.#parser.associations.get(object) ?? {};
    const is_use = ({ mesh, primitive }) => mesh === meshes && primitive === primitives;
    return [...this.#containers.values()].find(({ uses }) => uses.some(is_use))?.patches ?? null;
  }

  #replace_accessors(definition, use) {
    const { json } = this.#parser;
    let container;
    try {
      container = new Container(json, definition);
    } catch (error) {
      throw this.#error_at(use, definition.extensions[kExtensionName].bufferView, error);
    }
    const known = this.#containers.get(container.key);
    if (known === undefined) {
      container.publish();
      this.#containers.set(container.key, container);
      for (const { view } of container.columns) this.#of_view.set(view, container);
    }
    (known ?? container).uses.push(use);
    (known ?? container).assign(definition);
  }

  // The buffers of a container's synthetic views.
  #load(container) {
    // The loader normalizes the weights of a skin when it makes the mesh, so they must be whole by then. Morph targets must be when
    // they are drawn first, because three makes a texture of them.
    const is_whole = container.requests.some(({ name }) => kOfDeformed.test(name));
    if (this.#options.patchByPatch !== true || is_whole)
      return this.#decoded(container).then((arrays) => container.buffers_of(arrays));
    const attributes = new Map();  // three's, by column
    const growing = new GrowingMesh(container, (column, first, count) => {
      const attribute = attributes.get(column);
      if (attribute === undefined) return;  // nothing of it was drawn
      const data = attribute.data ?? attribute;
      data.addUpdateRange(first, count);
      data.needsUpdate = true;
    });
    for (const column of container.columns)
      growing.buffers.then(() => this.#parser.getDependency('accessor', column.number))
        .then((attribute) => attributes.set(column, attribute));
    const whole = this.#decoded(container, growing).catch((error) => {
      growing.clear();
      throw error;
    });
    this.#growing.push(whole);
    // If no part has come, the fallback's arrays are used.
    return Promise.race([growing.buffers,
      whole.then((arrays) => (growing.has_begun ? growing.buffers : container.buffers_of(arrays)))]);
  }

  // The decoded arrays, in the order of columns.
  #decoded(container, growing) {
    return this.#run(container, (signal) => this.#decode(container, signal, growing));
  }

  // Calls use(signal). If one container fails, the load fails. So the others end too.
  async #run(container, use) {
    const { manager } = this.#parser.options, item = this.#place_of(container.uses[0], container.view);
    const signals = [this.#options.signal, manager.abortController?.signal].filter((signal) => signal !== undefined);
    const controller = new AbortController();
    this.#running.add(controller);
    for (const signal of signals) signal.addEventListener('abort', this.#stop);  // once: it is one function
    if (this.#failure !== null || signals.some(({ aborted }) => aborted)) controller.abort();
    manager.itemStart(item);
    try {
      return await use(controller.signal);
    } catch (error) {
      manager.itemError(item);
      this.#failure ??= this.#error_at(container.uses[0], container.view, error);
      this.#stop();
      throw this.#failure;
    } finally {
      this.#running.delete(controller);
      if (this.#running.size === 0) for (const signal of signals) signal.removeEventListener('abort', this.#stop);
      manager.itemEnd(item);
    }
  }

  async #decode(container, signal, growing) {
    const options = { attributes: container.requests, signal,
      onProgress: (done, total) => this.#progress(container, done, total) };
    try {
      if (growing !== undefined) options.onPart = (part, counts) => this.#add(container, growing, part, counts);
      const mesh = await this.#decode_bytes(container, options);
      container.fit(mesh);
      this.#set_facts(container, mesh);
      return [mesh.indices, ...mesh.attributes.map(({ array }) => array)];
    } catch (error) {
      if (!may_fall_back(error) || !container.has_fallback || growing?.has_begun === true) throw error;
      return this.#fallback(container);
    }
  }

  #set_facts(container, { faceCount, pointCount, patchCount, hasResidue, isCondensed, firstFaces, chosen, way = 'wasm' }) {
    const { byteLength: bytes } = this.#parser.json.bufferViews[container.view], { why } = container;
    container.patches = { bytes, faceCount, pointCount, patchCount, hasResidue, isCondensed, firstFaces, way, ...(why && { why }), ...(chosen && { chosen }) };
  }

  // Attributes in the order of columns; null if the arrays are to be decoded.
  async #decode_on_gpu(container, signal) {
    const { view } = container;
    try {
      const { decode_for } = await import('./gpu_attributes.js');
      const bytes_of = () => this.#asset?.view(view) ?? until_abort(this.#parser.getDependency('bufferView', view), signal);
      const { mesh, attributes } = await decode_for(this.#options.gpu, container, bytes_of, signal), { patchCount } = mesh;
      this.#set_facts(container, mesh);
      this.#progress(container, patchCount, patchCount);
      return attributes;
    } catch (error) {
      if (signal.aborted) throw error;
      container.why = error.message;
      return null;
    }
  }

  async #decode_bytes(container, options) {
    const { view, uses: [place], may_choose } = container;
    if (this.#asset !== undefined)
      return this.#pool.decodeView(this.#asset, view, { ...options, place, choose: may_choose ? this.#options.choose : null,
        check: (counts) => container.check(counts) });
    const bytes = await until_abort(this.#parser.getDependency('bufferView', view), options.signal);
    return options.onPart === undefined ? this.#pool.decodeContainer(bytes, options) : this.#pool.decodePatches(bytes, options);
  }

  #add(container, growing, part, counts) {
    growing.add(part, counts);
    this.#options.onPart?.(part, container.uses[0]);
  }

  async #fallback({ columns }) {
    const attributes = await Promise.all(columns.map(({ source }) => this.#parser.getDependency('accessor', source)));
    return attributes.map((attribute, i) => {
      if (attribute.data === undefined) return attribute.array;
      const { components, Type, count } = columns[i], { array, stride } = attribute.data;
      const values = new Type(count * components);
      for (let k = 0; k < values.length; ++k)
        values[k] = array[attribute.offset + Math.floor(k / components) * stride + (k % components)];
      return values;
    });
  }

  #progress(container, done, total) {
    Object.assign(container, { done, total });
    const sum = (name) => [...this.#containers.values()].reduce((all, other) => all + other[name], 0);
    this.#options.onProgress?.(sum('done'), sum('total'), container.uses[0]);
  }

  // The place of an error, such as: assets/ship.bin: mesh 2 "hull", primitive 0
  #place_of({ mesh, primitive }, view) {
    const { json, options } = this.#parser;
    const uri = json.buffers?.[json.bufferViews?.[view]?.buffer]?.uri ?? '', { name } = json.meshes[mesh];
    const file = this.#options.file ?? (options.path ?? '') + (uri.startsWith('data:') ? '' : uri);
    return `${file === '' ? '' : `${file}: `}mesh ${mesh}${name === undefined ? '' : ` "${name}"`}, primitive ${primitive}`;
  }
  #error_at({ mesh, primitive }, view, cause) {
    const error = new PsplitError(`${this.#place_of({ mesh, primitive }, view)}: ${cause.message ?? cause}`, cause.code ?? 'failed');
    return Object.assign(error, { patch: cause.patch, mesh, primitive, cause });
  }
}
