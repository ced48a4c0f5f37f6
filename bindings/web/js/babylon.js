// The extension PSPLIT_mesh_draco_patches for Babylon.js' glTF loader. Before the loader reads a mesh, each primitive of the
// extension gets accessors and buffer views of its own, whose bytes are the arrays of the decoded mesh. So the loader works as
// for an asset that is not compressed. Primitives in stock Draco get them too, so that Babylon.js needs no decoder of draco3d.
import { ArrivingAsset } from './arriving_asset.js';
import { error_from_data, PsplitError } from './error.js';
import { check_counts, draco_primitive, index_type, is_all_stored, kComponentCounts, kComponentTypes, kDraco, kExtensionName, kIndexArrays, number_of, packed, set_number, stored_primitive, use_fine_meshes } from './gltf.js';
import { GrowingMesh } from './growing_mesh.js';
import { signal_of } from './job.js';
import { createPool } from './pool.js';
import { array_of } from './types.js';

let default_pool;
// The container of each of Babylon.js' meshes.
const containers_of = new WeakMap();

export const patchesOf = (mesh) => containers_of.get(mesh.sourceMesh ?? mesh)?.patches ?? null;

export function registerPsplit(registerGLTFExtension, options) {
  // If this were an extension of glTF, Babylon.js would make none for assets in stock Draco alone.
  registerGLTFExtension(kExtensionName, false, (loader) => new PatchesLoader(loader, options ?? {}));
}

// Assets that arrive, by number: { asset, signal, end, patchByPatch, onProgress, onPart, choose }, and `growing`, the promises of meshes
// that are shown patch by patch, and `uploads`. Babylon.js gets their JSON with addresses of buffers that have the number.
const arriving = new Map(), kAddress = 'psplit-arriving:';
let next_number = 0;
const arriving_of = ({ uri = '' }) => (uri.startsWith(kAddress) ? arriving.get(Number(uri.slice(kAddress.length))) : undefined);

export async function loadStreaming(load, url, scene, options) {
  const { signal: outer, onProgress, onPart, choose, patchByPatch = true, ...rest } = options ?? {}, { signal, end } = signal_of(outer);
  const number = next_number++, source = { signal, end, patchByPatch, onProgress, onPart, choose, growing: [], uploads: [] };
  let whole = null;
  try {
    const asset = await ArrivingAsset.open(url, signal, undefined, choose), { json } = asset;
    if (json === null) throw new PsplitError(`${url}: the file is a container without a glTF asset`, 'invalid-input');
    if (!json.extensionsUsed?.includes(kExtensionName)) throw new PsplitError(`${url}: the asset has no ${kExtensionName}`, 'unsupported');
    arriving.set(number, Object.assign(source, { asset }));
    const text = JSON.stringify({ ...json, buffers: json.buffers?.map((buffer) => ({ ...buffer, uri: `${kAddress}${number}` })) });
    const loaded = await load(`data:${text}`, scene, { rootUrl: url.slice(0, url.lastIndexOf('/') + 1), pluginExtension: '.gltf', ...rest });
    if (signal.aborted) throw new PsplitError('aborted', 'aborted');
    for (const upload of source.uploads) upload.flush();
    whole = Promise.all(source.growing).then(() => {});
    whole.then(end, end);
    return Object.assign(loaded ?? {}, { psplit: { whole } });
  } catch (error) {
    throw signal.aborted ? new PsplitError('aborted', 'aborted') : error;
  } finally {
    arriving.delete(number);
    if (whole === null) end();
  }
}

const placed = (error, place, extension = kExtensionName) => error_from_data({ code: error.code, patch: error.patch,
  message: `${place}/extensions/${extension}: ${error.message}` });
const bytes_of = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);

// Throws if a mesh does not fit the accessors. If it consists of chosen patches, the container's own accessors get its counts. So do
// accessors of stock Draco, because Babylon.js itself does not compare their counts.
function fit({ gltf, primitive, stored, accessors, is_draco }, mesh) {
  const { chosen, faceCount, pointCount } = mesh;
  if (chosen === undefined && !is_draco) return check_counts(gltf, primitive, stored.attributes, mesh);
  for (const { name, componentCount } of is_draco ? mesh.attributes : [])
    if (componentCount !== kComponentCounts[accessors.get(name).type])
      throw new PsplitError(`${name} has ${componentCount} components, but its accessor has the type ${accessors.get(name).type}`, 'invalid-input');
  for (const accessor of accessors.values()) accessor.count = pointCount;
  const indices = accessors.get(undefined);
  Object.assign(indices, { count: 3 * faceCount, componentType: index_type(indices, pointCount) });
}

// The indices or an attribute of a mesh, as its accessor says.
class Column {
  #accessor;

  constructor(view, accessor) {
    this.view = view;
    this.#accessor = accessor;
    this.components = this.stride = kComponentCounts[accessor.type];
  }
  get count() {
    return this.#accessor.count;
  }
  get Type() {
    return array_of(kComponentTypes[this.#accessor.componentType]);
  }
  get width() {
    return this.Type.BYTES_PER_ELEMENT;
  }
  make_array() {
    return new this.Type(this.count * this.components);
  }
}

// A mesh that is shown patch by patch: its columns, whose memory Babylon.js' buffers have, and what of them the GPU lacks.
class Upload {
  meshes = [];  // Babylon.js'
  #container;
  #growing;
  #stale = new Map();  // [first, end) of an array's components, by column

  constructor(container) {
    const [indices, ...attributes] = [...container.accessors].map(([view, accessor]) => new Column(view, accessor));
    this.#container = container;
    this.#growing = new GrowingMesh({ indices, attributes, columns: [indices, ...attributes], fit: (mesh) => fit(container, mesh) },
    (of, first, count) => {
      const [begin, end] = this.#stale.get(of) ?? [Infinity, 0];
      this.#stale.set(of, [Math.min(begin, first), Math.max(end, first + count)]);
    });
    // The bytes of the columns by their names, when the first part is there.
    this.arrays = this.#growing.buffers.then((buffers) =>
      (this.buffers = new Map([...buffers].map(([name, buffer]) => [name, new Uint8Array(buffer)]))));
  }
  get has_begun() {
    return this.#growing.has_begun;
  }

  add(part, counts) {
    this.#growing.add(part, counts);
    this.flush();
  }
  clear() {
    this.#growing.clear();
    this.flush();
  }

  // Tells the GPU of what changed, if all meshes have their buffers. Otherwise it is told later.
  flush() {
    const { meshes } = this;
    if (this.buffers === undefined || meshes.length < this.#container.uses || meshes.some(({ geometry }) => !geometry)) return;
    for (const { geometry } of meshes) {
      const engine = geometry.getEngine(), vertices = geometry.getVerticesDataKinds().map((kind) => geometry.getVertexBuffer(kind));
      for (const [{ view: name, width }, [first, end]] of this.#stale) {
        const bytes = this.buffers.get(name);
        if (name === undefined) {
          if (geometry.getIndexBuffer()) engine.updateDynamicIndexBuffer(geometry.getIndexBuffer(), geometry.getIndices());
          continue;
        }
        const buffer = vertices.find((vertex) => vertex.getData()?.buffer === bytes.buffer)?.getBuffer();
        if (buffer) engine.updateDynamicVertexBuffer(buffer, bytes.subarray(width * first, width * end), width * first);
      }
    }
    this.#stale.clear();
  }
}

class PatchesLoader {
  // The members that Babylon.js asks for.
  name = kExtensionName;
  enabled;

  #loader;
  #pool;
  #takes_draco;
  #gpu;
  #columns = new Map();  // { container, name } by buffer view; the name of indices is undefined
  #by_primitive = new Map();  // containers
  #sources = new Map();  // sources that arrive, by Upload
  #abort = new AbortController();

  constructor(loader, { pool, draco = true, gpu = false }) {
    this.#loader = loader;
    this.#pool = pool;
    this.#gpu = gpu;
    this.#takes_draco = draco && loader.isExtensionUsed(kDraco);
    this.enabled = loader.isExtensionUsed(kExtensionName) || this.#takes_draco;
  }

  // Babylon.js disposes of a loader also when the load is done. Meshes that have begun to grow go on.
  dispose() {
    this.#abort.abort();
    for (const [upload, { end }] of this.#sources) if (!upload.has_begun) end();
  }

  onLoading() {
    const { gltf } = this.#loader, containers = new Map();
    use_fine_meshes(gltf);
    (gltf.meshes ?? []).forEach(({ primitives }, m) => primitives.forEach((primitive, p) => {
      const place = `/meshes/${m}/primitives/${p}`;
      try {
        const patches = stored_primitive(gltf, primitive), stored = patches ?? this.#draco(gltf, primitive);
        if (stored === undefined) return;
        const { [kExtensionName]: own, [kDraco]: draco, ...extensions } = primitive.extensions;
        const key = JSON.stringify([own ?? draco, primitive.attributes, primitive.indices, primitive.targets]);
        if (!containers.has(key)) containers.set(key, this.#add_accessors(gltf, primitive, stored, place, { mesh: m, primitive: p }));
        const container = containers.get(key);
        if (patches === undefined) {
          primitive.extensions = extensions;  // or Babylon.js decodes it as well
          container.is_draco = container.is_whole = true;
        }
        container.may_choose &&= is_all_stored(primitive, stored.attributes);
        this.#by_primitive.set(primitive, container);
        ++container.uses;
        // Babylon.js adds morph targets to the points when it makes the mesh, so these must be whole by then.
        container.is_whole ||= primitive.targets !== undefined;
        for (const [name, { index }] of container.accessors) set_number(primitive, name, index);
      } catch (error) {
        throw placed(error, place);
      }
    }));
  }

  // A primitive in stock Draco that this takes.
  #draco(gltf, primitive) {
    return this.#takes_draco && (primitive.mode ?? 4) === 4 && primitive.indices !== undefined ? draco_primitive(gltf, primitive) : undefined;
  }

  // Null for buffer views of the asset, which the loader then loads itself.
  loadBufferViewAsync(_, view) {
    const column = this.#columns.get(view);
    if (column === undefined) return null;
    const { container, name } = column, arrays = () => (container.arrays ??= this.#load(container)).then((all) => all.get(name));
    if (container.on_gpu === undefined) return arrays();
    return container.on_gpu.then((buffers) => buffers?.take(name, (stride) => (view.byteStride = stride)) ?? arrays());
  }

  // Null if the loader makes the geometry alone. It says which mesh has it.
  _loadVertexDataAsync(context, primitive, mesh) {
    const container = this.#by_primitive.get(primitive);
    if (container === undefined || container.meshes.includes(mesh)) return null;
    container.meshes.push(mesh);
    containers_of.set(mesh, container);
    if (!this.#gpu) return null;
    return (container.on_gpu ??= this.#decode_on_gpu(container)).then(async (buffers) => {
      // This time the loader makes it, of arrays or of the buffers without their indices.
      const geometry = await this.#loader._loadVertexDataAsync(context, primitive, mesh);
      buffers?.index(geometry);
      return geometry;
    });
  }

  // Null for buffers that Babylon.js loads itself.
  loadBufferAsync(_, buffer, byteOffset, byteLength) {
    return arriving_of(buffer)?.asset.buffer(buffer.index, byteOffset, byteLength) ?? null;
  }

  // A container and its accessors.
  #add_accessors(gltf, { attributes, indices, targets }, stored, place, numbers) {
    const primitive = { attributes: { ...attributes }, indices, targets: targets?.map((target) => ({ ...target })) };
    const container = { gltf, primitive, stored, place, numbers, arrays: undefined, uses: 0, meshes: [], is_whole: false,
      is_draco: false, may_choose: true, on_gpu: undefined, why: undefined, patches: null, accessors: new Map() };  // its own, by name; the indices come first
    for (const name of [undefined, ...stored.attributes.map((attribute) => attribute.name)]) {
      const view = { buffer: gltf.bufferViews[stored.bufferView].buffer, byteLength: 0, index: gltf.bufferViews.length };
      gltf.bufferViews.push(view);
      this.#columns.set(view, { container, name });
      const index = gltf.accessors.length;
      container.accessors.set(name, { ...gltf.accessors[number_of(primitive, name)], bufferView: view.index, byteOffset: 0, index });
      gltf.accessors.push(container.accessors.get(name));
    }
    return container;
  }

  // Resolves to the bytes of a container's columns by their names: whole, or when the first patches are there.
  #load(container) {
    const source = this.#source_of(container), is_skin = container.stored.attributes.some(({ name }) => name.startsWith('WEIGHTS_'));
    if (source?.patchByPatch !== true || container.is_whole || is_skin) return this.#decode(container, source);
    const upload = new Upload(container);
    upload.meshes = container.meshes;
    source.uploads.push(upload);
    this.#sources.set(upload, source);
    const whole = this.#decode(container, source, upload).catch((error) => {
      upload.clear();
      throw source.signal.aborted ? new PsplitError('aborted', 'aborted') : error;
    });
    source.growing.push(whole);
    whole.catch(() => {});
    // Without a first part, the fallback has the arrays.
    return Promise.race([upload.arrays, whole.then((arrays) => (upload.has_begun ? upload.arrays : arrays))]);
  }

  // Resolves to GpuBuffers, or to null if the container is to be decoded without the GPU.
  async #decode_on_gpu(container) {
    const { decode_for } = await import('./babylon/gpu_buffers.js'), { gltf, stored } = container, source = this.#source_of(container);
    const bytes_of = () => source?.asset.view(stored.bufferView) ?? this.#load_view(gltf, stored.bufferView), { signal, end } = signal_of(this.#abort.signal, source?.signal);
    const buffers = await decode_for(this.#loader, container, source, bytes_of, (mesh) => fit(container, mesh), signal).finally(end);
    if (buffers !== null) this.#set_facts(container, buffers.mesh);
    return buffers;
  }
  #source_of({ gltf, stored }) {
    return arriving_of(gltf.buffers[gltf.bufferViews[stored.bufferView].buffer]);
  }
  #set_facts(container, { faceCount, pointCount, patchCount, hasResidue, isCondensed, firstFaces, chosen, way = 'wasm' }) {
    const { byteLength: bytes } = container.gltf.bufferViews[container.stored.bufferView], { why } = container;
    container.patches = { bytes, faceCount, pointCount, patchCount, hasResidue, isCondensed, firstFaces, way, ...(why && { why }), ...(chosen && { chosen }) };
  }

  async #decode(container, source, upload) {
    const { gltf, primitive, stored, place } = container, signal = upload === undefined ? this.#abort.signal : source.signal;
    try {
      const mesh = await this.#decode_bytes(container, signal, source, upload);
      fit(container, mesh);
      if (!container.is_draco) this.#set_facts(container, mesh);
      const Type = kIndexArrays[container.accessors.get(undefined).componentType], { indices } = mesh;
      return new Map([[undefined, bytes_of(indices instanceof Type ? indices : new Type(indices))],
        ...mesh.attributes.map(({ name, array }) => [name, bytes_of(array)])]);
    } catch (error) {
      // A loader may read the fallback in place of a container, except if the container is invalid.
      const columns = [...container.accessors.keys()].map((name) => [name, number_of(primitive, name)]);
      const has_fallback = columns.every(([, accessor]) => gltf.accessors[accessor].bufferView !== undefined);
      const is_fault = !(error instanceof PsplitError) || error.code === 'invalid-input' || error.code === 'aborted';
      if (is_fault || !has_fallback || upload?.has_begun === true) throw placed(error, place, container.is_draco ? kDraco : undefined);
      return new Map(await Promise.all(columns.map(async ([name, number]) => {
        const accessor = gltf.accessors[number], { bufferView: view } = accessor;
        return [name, packed(await this.#load_view(gltf, view), accessor, gltf.bufferViews[view])];
      })));
    }
  }

  async #decode_bytes({ gltf, primitive, stored: { bufferView: view, attributes }, numbers, is_draco, may_choose }, signal, source, upload) {
    const pool = this.#pool ?? (default_pool ??= createPool());
    if (source !== undefined && !is_draco) {
      const { asset, onProgress, onPart, choose } = source;
      const add = (part, counts) => {
        upload.add(part, counts);
        onPart?.(part, counts);
      };
      const both = signal_of(signal, source.signal);
      try {
        return await pool.decodeView(asset, view, { attributes, signal: both.signal, onProgress, onPart: upload === undefined ? onPart : add,
          choose: may_choose ? choose : null, place: numbers, check: (counts) => check_counts(gltf, primitive, attributes, counts) });
      } finally {
        both.end();
      }
    }
    const data = await this.#load_view(gltf, view);
    // The data is a part of the file's buffer, which must stay.
    return pool[is_draco ? 'decodeDraco' : 'decodeContainer'](data.slice(), { attributes, transfer: true, signal });
  }

  async #load_view(gltf, view) {
    const data = await this.#loader.loadBufferViewAsync(`/bufferViews/${view}`, gltf.bufferViews[view]);
    return bytes_of(data);
  }
}
