// A GLB or glTF file, or a container alone, whose bytes are used as they arrive.
import { ArrivingBytes, fetched } from './arriving.js';
import { as_psplit_error, PsplitError } from './error.js';
import { choice } from './files.js';
import { check_counts, kExtensionName, stored_primitive, use_fine_meshes } from './gltf.js';

const kGlb = 0x46546c67, kContainer = 0x4c505350, kJsonChunk = 0x4e4f534a, kChunkHeader = 8, kGlbHeader = 12;
const invalid = (message) => new PsplitError(message, 'invalid-input');

const ends_early = ({ url }, at, end) => invalid(`${url || 'the response'}: it ends early, after ${at} of at least ${end} bytes`);
// The bytes [begin, end) of a file. Throws if there are fewer.
function whole(bytes, file, begin, end) {
  if (bytes.length < end - begin) throw ends_early(file, begin + bytes.length, end);
  return bytes;
}

// Opens a file that arrives from the first byte to the last: { file, url }.
async function open_file(input, signal) {
  const { url, body } = await fetched(input, signal);
  return { file: new ArrivingBytes(body, signal, url), url };
}

// The container that a primitive names. Primitives with equal keys are equal.
const key_of = ({ attributes, indices, targets, extensions }) => JSON.stringify([attributes, indices, targets, extensions[kExtensionName]]);

export class ArrivingAsset {
  json = null;  // of a container alone
  #open;
  #file;        // ArrivingBytes, or what #open makes
  #resolve;
  #binary = 0;  // where the GLB's binary chunk begins in the file
  #buffers = new Map();  // ArrivingBytes of other files
  #signal;

  /**
   * Resolves when the JSON is there.
   * @param {string | URL | Request | Response} input
   * @param {AbortSignal} [signal] ends the arrival
   * @param {(uri: string) => URL | Request} [resolve] what to fetch for an address of the JSON
   * @param {function} [choose] the caller's option: the files may then be asked for in parts
   */
  static async open(input, signal, resolve, choose) {
    if (typeof (choose ?? Object) !== 'function') throw invalid('the option `choose` is not a function');
    const open = choose == null ? open_file : (await choice()).open_ranged;
    const { file, url } = await open(input, signal), asset = new ArrivingAsset();
    asset.#open = open;
    asset.#file = file;
    asset.#resolve = resolve ?? ((uri) => new URL(uri, url || globalThis.location?.href));
    asset.#signal = signal;
    await asset.#read_json();
    return asset;
  }

  async #read_json() {
    const word = (bytes, at) => new DataView(bytes.buffer).getUint32(at, true);
    const head = await this.#file.bytes(0, kGlbHeader + kChunkHeader);
    const magic = head.length < 4 ? 0 : word(head, 0);
    if (magic === kContainer) return;
    let text = null;
    if (magic === kGlb && head.length === kGlbHeader + kChunkHeader && word(head, 4) === 2 && word(head, 16) === kJsonChunk) {
      const end = head.length + word(head, 12);
      text = whole(await this.#file.bytes(head.length, end), this.#file, head.length, end);
      this.#binary = end + kChunkHeader;
      this.#file.expect?.(word(head, 8));
    } else if (magic !== kGlb) {
      text = await this.#file.bytes(0);
    }
    try {
      this.json = JSON.parse(new TextDecoder().decode(text));
    } catch {
      throw invalid('the file is no GLB, no glTF and no container');
    }
  }

  // The buffer views with containers: { view, attributes, primitive, uses }. `uses` has the places of the primitives that are
  // made of it. Errors: as stored_primitive.
  containers() {
    if (this.json === null) return [{ view: null, uses: [{}] }];
    const by_key = new Map();
    try {
      use_fine_meshes(this.json);
      for (const [mesh, { primitives }] of (this.json.meshes ?? []).entries())
        for (const [number, primitive] of primitives.entries()) this.#add_container(by_key, primitive, { mesh, primitive: number });
    } catch (error) {
      throw as_psplit_error(error);
    }
    return [...by_key.values()];
  }
  #add_container(by_key, primitive, use) {
    try {
      const stored = stored_primitive(this.json, primitive);
      if (stored === undefined) return;
      const key = key_of(primitive);
      if (!by_key.has(key)) by_key.set(key, { view: stored.bufferView, attributes: stored.attributes, primitive, uses: [] });
      by_key.get(key).uses.push(use);
    } catch (error) {
      throw this.placed(as_psplit_error(error), use);
    }
  }

  // Throws if a decoded mesh does not fit the accessors. The caller knows the place.
  check({ primitive, attributes }, mesh) {
    if (primitive !== undefined) check_counts(this.json, primitive, attributes, mesh);
  }
  // The error with its place, unless it is not the decoder's.
  placed(error, { mesh, primitive }) {
    if (mesh === undefined || !(error instanceof PsplitError) || error.code === 'aborted') return error;
    const message = `mesh ${mesh}, primitive ${primitive}: ${error.message}`;
    return Object.assign(new PsplitError(message, error.code), { patch: error.patch, mesh, primitive, cause: error });
  }

  // The bytes of a buffer view as they arrive; null: of the whole file.
  async* chunks(view) {
    const { file, begin, end } = await this.place(view);
    let at = begin;
    for await (const chunk of file.chunks(begin, end)) {
      at += chunk.length;
      yield chunk;
    }
    if (end !== Infinity && at < end) throw ends_early(file, at, end);
  }
  // Where they are: in a file, to before `end`.
  async place(view) {
    if (view === null) return { file: this.#file, begin: 0, end: this.#file.total ?? Infinity };
    const { buffer, byteOffset = 0, byteLength } = this.json.bufferViews[view];
    if (![byteOffset, byteLength].every((number) => Number.isSafeInteger(number) && number >= 0)) throw invalid(`buffer view ${view} has no valid place`);
    const { bytes: file, begin } = await this.#buffer(buffer);
    return { file, begin: begin + byteOffset, end: begin + byteOffset + byteLength };
  }
  // All bytes of a buffer view, or of a part of a buffer.
  view(number) {
    const { buffer, byteOffset = 0, byteLength } = this.json.bufferViews[number];
    return this.buffer(buffer, byteOffset, byteLength);
  }
  async buffer(number, offset = 0, length = this.json.buffers[number].byteLength) {
    const { bytes, begin } = await this.#buffer(number);
    return whole(await bytes.bytes(begin + offset, begin + offset + length), bytes, begin + offset, begin + offset + length);
  }

  // Where a buffer's bytes arrive. Other files are asked for when they are needed.
  async #buffer(number) {
    const uri = this.json.buffers?.[number]?.uri;
    if (uri === undefined && this.#binary === 0) throw invalid(`buffer ${number} has no bytes`);
    if (uri === undefined) return { bytes: this.#file, begin: this.#binary };
    if (!this.#buffers.has(number))
      this.#buffers.set(number, this.#open(this.#resolve(uri), this.#signal).then(({ file }) => {
        file.expect?.(this.json.buffers[number].byteLength);
        return file;
      }));
    return { bytes: await this.#buffers.get(number), begin: 0 };
  }
}
