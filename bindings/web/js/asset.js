// psplit/gltf: a glTF asset as typed arrays, without a loader. Primitives in patches, in stock Draco, and without compression.
import { as_psplit_error, PsplitError } from './error.js';
import { draco_primitive, fitting_indices, kComponentCounts, kComponentTypes, kIndexArrays, names_of, number_of, packed, set_number, slot_of, stored_primitive,
  use_fine_meshes } from './gltf.js';
import { decodeContainer, decodeDraco } from './index.js';
import { bytes_of, signal_of } from './job.js';
import { is_node, node_module } from './node.js';
import { array_of } from './types.js';

const kMeshopt = ['EXT_meshopt_compression', 'KHR_meshopt_compression'];
const kGlb = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
const kMostUnbacked = 2 ** 30;  // bytes of zeros that accessors without a buffer view have
// Of meshoptimizer's modes that of attributes takes the fewest bytes: two bits for 256 zeros.
const kMostBytesOfAByte = 1024;
// What its decoder does not check. Filters of other strides change other bytes of the view.
const is_index = (stride) => stride === 2 || stride === 4;
const kMeshoptRows = { ATTRIBUTES: (stride) => stride % 4 === 0 && stride > 0 && stride <= 256, INDICES: is_index,
  TRIANGLES: (stride, count) => is_index(stride) && count % 3 === 0 };
const kMeshoptFilters = ['NONE', 'OCTAHEDRAL', 'QUATERNION', 'EXPONENTIAL', 'COLOR'];
const on_this_thread = { decodeContainer, decodeDraco };

const invalid = (message) => new PsplitError(message, 'invalid-input');
const ended = () => new PsplitError('aborted', 'aborted');

async function fetch_bytes(url, signal) {
  try {
    if (is_node && url.protocol === 'file:') {
      const { readFile } = await node_module('node:fs/promises');
      return new Uint8Array(await readFile(url, { signal }));
    }
    const response = await fetch(url, { signal });
    if (!response.ok) throw new Error(`HTTP status ${response.status}`);
    return new Uint8Array(await response.arrayBuffer().catch(({ message }) => { throw new Error(`it ended early (${message})`); }));
  } catch (error) {
    if (signal.aborted) throw ended();
    throw new PsplitError(`${url} cannot be loaded: ${error.message}`, 'failed');
  }
}

// The JSON and the binary chunk of a GLB; or the JSON of a .gltf.
function parse(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const json_of = (text) => {
    try {
      return JSON.parse(new TextDecoder().decode(text));
    } catch (error) {
      throw invalid(`not a glTF asset: ${error.message}`);
    }
  };
  if (bytes.length < 20 || view.getUint32(0, true) !== kGlb) return { json: json_of(bytes) };
  const version = view.getUint32(4, true), length = view.getUint32(8, true), end = Math.min(bytes.length, length), chunks = new Map();
  if (version !== 2) throw new PsplitError(`the GLB has version ${version}`, 'unsupported');
  for (let at = 12; at + 8 <= end;) {
    const chunk_bytes = view.getUint32(at, true), kind = view.getUint32(at + 4, true);
    if (at + 8 + chunk_bytes > end) throw invalid(`the GLB ends early: ${bytes.length} of ${length} bytes`);
    if (!chunks.has(kind)) chunks.set(kind, bytes.subarray(at + 8, at + 8 + chunk_bytes));
    at += 8 + chunk_bytes + (-chunk_bytes & 3);
  }
  if (!chunks.has(kJsonChunk)) throw invalid('the GLB has no JSON');
  return { json: json_of(chunks.get(kJsonChunk)), binary: chunks.get(kBinaryChunk) };
}

class Asset {
  #json;
  #binary;
  #url;
  #decoder;
  #meshopt;
  #signal;
  #unbacked = 0;         // bytes of accessors without a buffer view
  #expanded = 0;         // bytes that meshoptimizer decodes
  #buffers = new Map();  // promises of bytes by number
  #views = new Map();    // compressed by meshoptimizer: promises of decoded bytes by number
  #meshes = new Map();   // promises of decoded meshes by their stored data, because primitives may share it

  constructor({ json, binary }, url, { pool, meshoptDecoder }, signal) {
    this.#json = json;
    this.#binary = binary;
    this.#url = url;
    this.#decoder = pool ?? on_this_thread;
    this.#meshopt = meshoptDecoder;
    this.#signal = signal;
  }

  async primitives() {
    use_fine_meshes(this.#json);
    const places = (this.#json.meshes ?? []).flatMap(({ name, primitives }, m) =>
      primitives.map((definition, p) => [definition, m, p, name === undefined ? '' : ` "${name}"`]));
    return Promise.all(places.map(async ([definition, m, p, name]) => {
      try {
        const { mode = 4, material } = definition;
        return { mesh: m, primitive: p, mode, ...(material !== undefined && { material }), ...await this.#primitive(definition) };
      } catch (error) {
        const { code, message, patch } = as_psplit_error(error);
        throw Object.assign(new PsplitError(`mesh ${m}${name}, primitive ${p}: ${message}`, code),
          { patch, mesh: m, primitive: p, cause: error });
      }
    }));
  }

  async #primitive(definition) {
    const patches = stored_primitive(this.#json, definition), draco = patches ?? draco_primitive(this.#json, definition);
    if (draco === undefined) return this.#plain_primitive(definition);
    const names = draco.attributes.map(({ name }) => name);
    try {
      const decoded = await (patches ? this.#patches(definition, patches) : this.#draco(definition, draco));
      return { ...decoded, ...arranged(definition, { ...await this.#attributes(definition, names, decoded.pointCount), ...decoded.attributes }) };
    } catch (error) {
      // A primitive that cannot be decoded may use its fallback, unless its data are invalid.
      const has_fallback = [undefined, ...names].every((name) => this.#json.accessors[number_of(definition, name)]?.bufferView !== undefined);
      if (!['unsupported', 'failed', 'out-of-memory'].includes(error.code) || !has_fallback) throw error;
      return this.#plain_primitive(definition);
    }
  }

  async #patches(definition, { bufferView, attributes }) {
    const mesh = await this.#decoded('decodeContainer', bufferView, attributes);
    return { coding: 'patches', pointCount: mesh.pointCount, indices: fitting_indices(this.#json, definition, mesh),
      attributes: by_name(mesh.attributes) };
  }
  async #draco(definition, { bufferView, attributes }) {
    const mesh = await this.#decoded('decodeDraco', bufferView, attributes);
    const Type = kIndexArrays[this.#json.accessors?.[definition.indices]?.componentType] ?? Uint32Array;
    const fits = mesh.pointCount < 2 ** (8 * Type.BYTES_PER_ELEMENT);
    return { coding: 'draco', pointCount: mesh.pointCount,
      indices: Type === Uint32Array || !fits ? mesh.indices : new Type(mesh.indices),
      attributes: by_name(mesh.attributes.map((attribute, i) => ({ ...attribute, normalized: attributes[i].normalized }))) };
  }
  #decoded(decode, view, attributes) {
    const key = JSON.stringify([decode, view, attributes]);
    if (!this.#meshes.has(key)) {
      this.#meshes.set(key, this.#view(view).then((bytes) => {
        if (this.#signal.aborted) throw ended();
        return this.#decoder[decode](bytes, { attributes, signal: this.#signal });
      }));
    }
    return this.#meshes.get(key);
  }

  async #plain_primitive(definition) {
    const counts = Object.values(definition.attributes ?? {}).map((i) => this.#accessor(i).count), { indices } = definition;
    const pointCount = counts.length > 0 ? Math.min(...counts) : 0;
    const values = await this.#attributes(definition, [], pointCount);
    return { coding: 'none', pointCount, indices: indices === undefined ? null : (await this.#values(indices)).array, ...arranged(definition, values) };
  }
  // The attributes that are not compressed, also of morph targets. `names`: the compressed attributes.
  async #attributes(definition, names, points) {
    const plain = names_of(definition).filter((name) => !names.includes(name));
    return Object.fromEntries(await Promise.all(plain.map(async (name) =>
      [name, await this.#values(number_of(definition, name), slot_of(definition, name)[2] && points)])));
  }

  #accessor(i) {
    const accessor = this.#json.accessors?.[i];
    if (accessor === undefined) throw invalid(`there is no accessor ${i}`);
    const { componentType, type, count } = accessor, is_typed = componentType in kComponentTypes && type in kComponentCounts;
    if (!is_typed || !Number.isInteger(count) || count < 0)
      throw invalid(`accessor ${i} has no valid type or count`);
    return accessor;
  }
  // Without a buffer view they are 0, but for sparse ones. `points`: of the primitive of a morph target.
  async #values(i, points) {
    const accessor = this.#accessor(i), { bufferView, componentType, count, type, normalized = false, sparse } = accessor;
    const componentCount = kComponentCounts[type], Type = array_of(kComponentTypes[componentType]), length = count * componentCount;
    const is_unbacked = bufferView === undefined;
    if (is_unbacked && ((points ?? count) !== count || (this.#unbacked += length * Type.BYTES_PER_ELEMENT) > kMostUnbacked))
      throw new PsplitError(`accessor ${i} has ${count} elements without a buffer view`, 'unsupported');
    const array = is_unbacked ? new Type(length)
      : new Type(packed(await this.#view(bufferView), accessor, this.#json.bufferViews[bufferView]).buffer);
    if (sparse !== undefined) await this.#apply_sparse(array, componentCount, accessor, sparse);
    return { type: kComponentTypes[componentType], componentCount, normalized, array };
  }
  async #apply_sparse(array, componentCount, { componentType, type }, { count, indices, values }) {
    const read = async (Type, { bufferView, byteOffset }, description) =>
      new Type(packed(await this.#view(bufferView), { ...description, byteOffset, count }, {}).buffer);
    const places = await read(kIndexArrays[indices.componentType], indices, { componentType: indices.componentType, type: 'SCALAR' });
    const from = await read(array.constructor, values, { componentType, type });
    places.forEach((place, i) =>
      array.set(from.subarray(i * componentCount, (i + 1) * componentCount), place * componentCount));
  }

  async #view(i) {
    const view = this.#json.bufferViews?.[i];
    if (view === undefined) throw invalid(`there is no buffer view ${i}`);
    const name = kMeshopt.find((extension) => view.extensions?.[extension] !== undefined);
    if (name === undefined || (this.#meshopt === undefined && this.#has_plain_bytes(view, name))) return this.#range(i, view);
    if (!this.#views.has(i)) this.#views.set(i, this.#decompressed(i, view, name));
    return this.#views.get(i);
  }
  async #range(i, { buffer, byteOffset = 0, byteLength }) {
    const bytes = await this.#buffer(buffer);
    if (!(byteOffset >= 0 && byteLength >= 0 && byteOffset + byteLength <= bytes.length)) {
      const { byteLength: all } = this.#json.buffers[buffer];
      throw invalid(bytes.length < all ? `buffer ${buffer} ends early: ${bytes.length} of ${all} bytes` : `buffer view ${i} is not in its buffer`);
    }
    return bytes.subarray(byteOffset, byteOffset + byteLength);
  }
  // A file may hold the decoded bytes as well, for loaders without the extension.
  #has_plain_bytes({ buffer }, name) {
    return !this.#json.extensionsRequired?.includes(name) && (this.#json.buffers?.[buffer]?.uri !== undefined || (buffer === 0 && this.#binary !== undefined));
  }
  async #decompressed(i, { byteLength, extensions }, name) {
    const { [name]: compressed } = extensions, { byteStride, count, mode, filter = 'NONE' } = compressed;
    if (this.#meshopt === undefined) {
      throw new PsplitError(`buffer view ${i} has ${name}: the option \`meshoptDecoder\` has to be a decoder, such as MeshoptDecoder of the ` +
        'npm package meshoptimizer', 'unsupported');
    }
    const source = await this.#range(i, compressed), size = count * byteStride;
    const is_valid = Number.isInteger(count) && count >= 0 && kMeshoptRows[mode]?.(byteStride, count) && kMeshoptFilters.includes(filter);
    if (!(is_valid && byteLength <= size)) throw invalid(`buffer view ${i} has ${name} of no valid mode, filter, byteStride or count`);
    // Views may share bytes, but a small file does not become huge.
    if ((this.#expanded += size) > kMostBytesOfAByte * source.buffer.byteLength) throw invalid(`buffer view ${i} has more bytes than ${name} can hold`);
    await this.#meshopt.ready;
    const bytes = new Uint8Array(size);
    try {
      this.#meshopt.decodeGltfBuffer(bytes, count, byteStride, source, mode, filter);
    } catch (error) {
      throw invalid(`buffer view ${i} has ${name}, which cannot be decoded: ${error.message}`);
    }
    return bytes.subarray(0, byteLength);
  }
  #buffer(i) {
    if (!this.#buffers.has(i)) this.#buffers.set(i, this.#load_buffer(i));
    return this.#buffers.get(i);
  }
  async #load_buffer(i) {
    const { uri } = this.#json.buffers?.[i] ?? {};
    if (uri === undefined) {
      if (i !== 0 || this.#binary === undefined) throw invalid(`there is no buffer ${i}`);
      return this.#binary;
    }
    if (uri.startsWith('data:')) {
      const comma = uri.indexOf(','), text = uri.slice(comma + 1);
      const characters = uri.slice(0, comma).endsWith(';base64') ? atob(text) : decodeURIComponent(text);
      return Uint8Array.from(characters, (character) => character.charCodeAt(0));
    }
    if (this.#url === undefined)
      throw invalid(`buffer ${i} is in the file ${uri}: the option \`url\` has to say where the asset is`);
    return fetch_bytes(new URL(uri, this.#url), this.#signal);
  }
}

// Attributes, also of morph targets, as the primitive has them.
function arranged({ targets }, values) {
  const of = { attributes: {}, ...(targets && { targets: targets.map(() => ({})) }) };
  for (const name of Object.keys(values)) set_number(of, name, values[name]);
  return of;
}

const by_name = (attributes) => Object.fromEntries(attributes.map(({ name, type, componentCount, normalized, array }) =>
  [name, { type, componentCount, normalized, array }]));
const absolute = (url) => (url == null ? undefined : new URL(url, globalThis.location?.href));

// Runs use(signal). What it began ends with the caller's signal, or if it fails.
async function ending(outer, use) {
  const { signal, end } = signal_of(outer);
  try {
    if (signal.aborted) throw ended();
    return await use(signal);
  } catch (error) {
    throw signal.aborted ? ended() : as_psplit_error(error);
  } finally {
    end();
  }
}

async function decoded_asset(bytes, options, signal) {
  const parsed = parse(bytes);
  return { json: parsed.json, primitives: await new Asset(parsed, absolute(options.url), options, signal).primitives() };
}

export async function decodeGlb(data, options) {
  const given = options ?? {}, bytes = bytes_of(data);
  return ending(given.signal, (signal) => decoded_asset(bytes, given, signal));
}

export async function decodeGltf(url, options) {
  const given = options ?? {};
  return ending(given.signal, async (signal) => {
    let address;
    try {
      address = absolute(url);
    } catch {
      throw invalid(`${url} is not an address`);
    }
    if (address === undefined) throw invalid('there is no address');
    return decoded_asset(await fetch_bytes(address, signal), { ...given, url: address }, signal);
  });
}
