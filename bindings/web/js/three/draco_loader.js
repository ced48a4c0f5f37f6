// The interface of three's DRACOLoader over a pool of psplit.
import { BufferAttribute, BufferGeometry, Color, FileLoader, InterleavedBuffer, InterleavedBufferAttribute, LinearSRGBColorSpace,
  Loader, LoadingManager, SRGBColorSpace } from 'three';
import { PsplitError } from '../error.js';
import { createPool } from '../pool.js';
import { aligned_stride, copy_elements } from '../aligned.js';

const kTypes = { Int8Array: 'int8', Uint8Array: 'uint8', Int16Array: 'int16', Uint16Array: 'uint16', Int32Array: 'int32',
  Uint32Array: 'uint32', Float32Array: 'float32' };

function attribute_of(array, item_size) {
  const bytes = item_size * array.BYTES_PER_ELEMENT, stride = aligned_stride(bytes) / array.BYTES_PER_ELEMENT;
  if (stride === item_size) return new BufferAttribute(array, item_size);
  const aligned = new array.constructor((array.length / item_size) * stride);
  copy_elements(array, item_size, aligned, stride);
  return new InterleavedBufferAttribute(new InterleavedBuffer(aligned, stride), item_size, 0);
}

function srgb_to_working(attribute) {
  const color = new Color();
  for (let i = 0; i < attribute.count; ++i) {
    color.setRGB(attribute.getX(i), attribute.getY(i), attribute.getZ(i), SRGBColorSpace);
    attribute.setXYZ(i, color.r, color.g, color.b);
  }
}

// A Draco stream begins with DRACO, the bitstream's version in two bytes, and its kind: 0 is a point cloud.
function is_point_cloud(buffer) {
  const header = new Uint8Array(buffer, 0, Math.min(8, buffer.byteLength));
  return header[7] === 0 && String.fromCharCode(...header.subarray(0, 5)) === 'DRACO';
}

export class PsplitDracoLoader extends Loader {
  #pool;
  #owns_pool;
  #workers;

  constructor(options) {
    const { manager, pool = null, fallback = null } = options instanceof LoadingManager ? { manager: options } : options ?? {};
    super(manager);
    this.#pool = pool;
    this.#owns_pool = pool === null;
    this.fallback = fallback;
    this.defaultAttributeIDs = { position: 'POSITION', normal: 'NORMAL', color: 'COLOR', uv: 'TEX_COORD' };
    this.defaultAttributeTypes = { position: 'Float32Array', normal: 'Float32Array', color: 'Float32Array', uv: 'Float32Array' };
  }

  // The decoder is found beside the package's code, so these two change nothing.
  setDecoderPath() {
    return this;
  }
  setDecoderConfig() {
    return this;
  }

  setWorkerLimit(limit) {
    this.#workers = limit;
    return this;
  }

  preload() {
    this.pool.ready().catch(() => {});  // decoding tells
    return this;
  }

  get pool() {
    this.#pool ??= createPool({ workers: this.#workers });
    return this.#pool;
  }

  load(url, onLoad, onProgress, onError) {
    const loader = new FileLoader(this.manager);
    loader.setPath(this.path).setResponseType('arraybuffer').setRequestHeader(this.requestHeader)
      .setWithCredentials(this.withCredentials);
    loader.setPriority?.(this.priority);  // of newer versions
    loader.setCache?.(this.cache);
    loader.load(url, (buffer) => this.parse(buffer, onLoad, onError), onProgress, onError);
  }

  parse(buffer, onLoad, onError) {
    this.decodeDracoFile(buffer, onLoad, null, null, SRGBColorSpace, onError);
  }

  decodeDracoFile(buffer, callback, attributeIDs, attributeTypes, vertexColorSpace = LinearSRGBColorSpace, onError = () => {}) {
    return this.decodeGeometry(buffer, {
      attributeIDs: attributeIDs || this.defaultAttributeIDs,
      attributeTypes: attributeTypes || this.defaultAttributeTypes,
      useUniqueIDs: Boolean(attributeIDs),
      vertexColorSpace,
    }).then(callback).catch(onError);
  }

  async decodeGeometry(buffer, task) {
    const { attributeIDs, attributeTypes, useUniqueIDs, vertexColorSpace } = task;
    const attributes = Object.entries(attributeIDs).map(([name, id]) =>
      ({ name, type: kTypes[attributeTypes[name]], ...(useUniqueIDs ? { uniqueId: id } : { semantic: id }) }));
    let mesh;
    try {
      if (is_point_cloud(buffer)) throw new PsplitError('the Draco stream is a point cloud', 'unsupported');
      mesh = await this.pool.decodeDraco(buffer, { attributes });
    } catch (error) {
      if (error.code !== 'unsupported' || this.fallback === null) throw error;
      return this.fallback.decodeGeometry(buffer.slice(0), task);  // which empties the buffer that it is given
    }
    const geometry = new BufferGeometry().setIndex(new BufferAttribute(mesh.indices, 1));
    for (const { name, array, componentCount } of mesh.attributes) {
      const attribute = attribute_of(array, componentCount);
      if (name === 'color') {
        if (vertexColorSpace === SRGBColorSpace) srgb_to_working(attribute);
        attribute.normalized = !(array instanceof Float32Array);
      }
      geometry.setAttribute(name, attribute);
    }
    return geometry;
  }

  dispose() {
    if (this.#owns_pool) this.#pool?.dispose();
    if (this.#owns_pool) this.#pool = null;
    return this;
  }
}
