// The extension PSPLIT_mesh_draco_patches for Babylon.js' glTF loader. Before the loader reads a mesh, each primitive of the
// extension gets accessors and buffer views of its own, whose bytes are the arrays of the decoded mesh. So the loader works as
// for an asset that is not compressed.
import { signal_of } from './arriving.js';
import { ArrivingAsset } from './arriving_asset.js';
import { error_from_data, PsplitError } from './error.js';
import { fitting_indices, kExtensionName, packed, stored_primitive } from './gltf.js';
import { createPool } from './pool.js';

let default_pool;

export function registerPsplit(registerGLTFExtension, options) {
  registerGLTFExtension(kExtensionName, true, (loader) => new PatchesLoader(loader, options?.pool));
}

// Assets that arrive: { asset, onProgress, onPart } by number. Babylon.js gets their JSON with addresses of buffers that have the
// number.
const arriving = new Map(), kAddress = 'psplit-arriving:';
let next_number = 0;
const arriving_of = ({ uri = '' }) => (uri.startsWith(kAddress) ? arriving.get(Number(uri.slice(kAddress.length))) : undefined);

export async function loadStreaming(load, url, scene, options) {
  const { signal: outer, onProgress, onPart, ...rest } = options ?? {}, { signal, end } = signal_of(outer), number = next_number++;
  try {
    const asset = await ArrivingAsset.open(url, signal), { json } = asset;
    if (json === null) throw new PsplitError(`${url}: the file is a container without a glTF asset`, 'invalid-input');
    if (!json.extensionsUsed?.includes(kExtensionName)) throw new PsplitError(`${url}: the asset has no ${kExtensionName}`, 'unsupported');
    arriving.set(number, { asset, onProgress, onPart });
    const text = JSON.stringify({ ...json, buffers: json.buffers?.map((buffer) => ({ ...buffer, uri: `${kAddress}${number}` })) });
    const loaded = await load(`data:${text}`, scene, { rootUrl: url.slice(0, url.lastIndexOf('/') + 1), pluginExtension: '.gltf', ...rest });
    if (signal.aborted) throw new PsplitError('aborted', 'aborted');
    return loaded;
  } catch (error) {
    throw signal.aborted ? new PsplitError('aborted', 'aborted') : error;
  } finally {
    arriving.delete(number);
    end();
  }
}

const placed = (error, place) => error_from_data({ code: error.code, patch: error.patch,
  message: `${place}/extensions/${kExtensionName}: ${error.message}` });
const bytes_of = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);

class PatchesLoader {
  // The members that Babylon.js asks for.
  name = kExtensionName;
  enabled;

  #loader;
  #pool;
  #columns = new Map();  // { container, name } by buffer view; the name of indices is undefined
  #abort = new AbortController();

  constructor(loader, pool) {
    this.#loader = loader;
    this.#pool = pool;
    this.enabled = loader.isExtensionUsed(kExtensionName);
  }

  dispose() {
    this.#abort.abort();
  }

  onLoading() {
    const { gltf } = this.#loader, containers = new Map();
    (gltf.meshes ?? []).forEach(({ primitives }, m) => primitives.forEach((primitive, p) => {
      const place = `/meshes/${m}/primitives/${p}`;
      try {
        const stored = stored_primitive(gltf, primitive);
        if (stored === undefined) return;
        const key = JSON.stringify([primitive.extensions[kExtensionName], primitive.attributes, primitive.indices]);
        if (!containers.has(key)) containers.set(key, this.#add_accessors(gltf, primitive, stored, place));
        const { attributes, indices } = containers.get(key);
        primitive.attributes = { ...primitive.attributes, ...attributes };
        primitive.indices = indices;
      } catch (error) {
        throw placed(error, place);
      }
    }));
  }

  // Null for buffer views of the asset, which the loader then loads itself.
  loadBufferViewAsync(_, view) {
    const column = this.#columns.get(view);
    if (column === undefined) return null;
    column.container.arrays ??= this.#decode(column.container);
    return column.container.arrays.then((arrays) => arrays.get(column.name));
  }

  // Null for buffers that Babylon.js loads itself.
  loadBufferAsync(_, buffer, byteOffset, byteLength) {
    return arriving_of(buffer)?.asset.buffer(buffer.index, byteOffset, byteLength) ?? null;
  }

  // Makes the accessors of a container. Returns their numbers.
  #add_accessors(gltf, { attributes, indices }, stored, place) {
    const container = { gltf, primitive: { attributes, indices }, stored, place, arrays: undefined };
    const add = (name, original) => {
      const view = { buffer: gltf.bufferViews[stored.bufferView].buffer, byteLength: 0, index: gltf.bufferViews.length };
      gltf.bufferViews.push(view);
      this.#columns.set(view, { container, name });
      const index = gltf.accessors.length;
      gltf.accessors.push({ ...gltf.accessors[original], bufferView: view.index, byteOffset: 0, index });
      return index;
    };
    return { indices: add(undefined, indices),
      attributes: Object.fromEntries(stored.attributes.map(({ name }) => [name, add(name, attributes[name])])) };
  }

  // Returns the bytes of a container's columns by their names.
  async #decode(container) {
    const { gltf, primitive, stored, place } = container, { signal } = this.#abort;
    try {
      const mesh = await this.#decode_bytes(gltf, stored, signal);
      return new Map([[undefined, bytes_of(fitting_indices(gltf, primitive, mesh))],
        ...mesh.attributes.map(({ name, array }) => [name, bytes_of(array)])]);
    } catch (error) {
      // A loader may read the fallback in place of a container, except if the container is invalid.
      const columns = [[undefined, primitive.indices],
        ...stored.attributes.map(({ name }) => [name, primitive.attributes[name]])];
      const has_fallback = columns.every(([, accessor]) => gltf.accessors[accessor].bufferView !== undefined);
      const is_fault = !(error instanceof PsplitError) || error.code === 'invalid-input' || error.code === 'aborted';
      if (is_fault || !has_fallback) throw placed(error, place);
      return new Map(await Promise.all(columns.map(async ([name, number]) => {
        const accessor = gltf.accessors[number], { bufferView: view } = accessor;
        return [name, packed(await this.#load_view(gltf, view), accessor, gltf.bufferViews[view])];
      })));
    }
  }

  async #decode_bytes(gltf, { bufferView: view, attributes }, signal) {
    const pool = this.#pool ?? (default_pool ??= createPool()), source = arriving_of(gltf.buffers[gltf.bufferViews[view].buffer]);
    if (source !== undefined) {
      const { asset, onProgress, onPart } = source;
      return pool.decodeStream(asset.chunks(view), { attributes, signal, onProgress, onPart });
    }
    const data = await this.#load_view(gltf, view);
    // The data is a part of the file's buffer, which must stay.
    return pool.decodeContainer(data.slice(), { attributes, transfer: true, signal });
  }

  async #load_view(gltf, view) {
    const data = await this.#loader.loadBufferViewAsync(`/bufferViews/${view}`, gltf.bufferViews[view]);
    return bytes_of(data);
  }
}
