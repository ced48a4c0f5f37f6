// KHR_draco_mesh_compression in GLTFLoader, in place of the loader's own extension, which needs a DRACOLoader of the page.
import { LinearSRGBColorSpace } from 'three';
import { draco_primitive } from '../gltf.js';

// three's names of attributes; others are in lower case.
const kNames = { POSITION: 'position', NORMAL: 'normal', TANGENT: 'tangent', TEXCOORD_0: 'uv', TEXCOORD_1: 'uv1', TEXCOORD_2: 'uv2',
  TEXCOORD_3: 'uv3', COLOR_0: 'color', WEIGHTS_0: 'skinWeight', JOINTS_0: 'skinIndex' };
const kArrays = { int8: 'Int8Array', uint8: 'Uint8Array', int16: 'Int16Array', uint16: 'Uint16Array', uint32: 'Uint32Array',
  float32: 'Float32Array' };

export class StockDraco {
  #loader;
  #placed;
  #in_turn;

  /**
   * @param {DRACOLoader} loader
   * @param {(error: Error, primitive: object) => Error} placed adds the place to an error
   * @param {(decoded: Promise<BufferGeometry>) => Promise<BufferGeometry>} in_turn may delay it
   */
  constructor(loader, placed, in_turn) {
    this.#loader = loader;
    this.#placed = placed;
    this.#in_turn = in_turn;
  }

  // GLTFLoader calls it.
  decodePrimitive(primitive, parser) {
    return this.#in_turn(this.#decode(primitive, parser));
  }
  async #decode(primitive, parser) {
    try {
      const { bufferView, attributes } = draco_primitive(parser.json, primitive), buffer = await parser.getDependency('bufferView', bufferView);
      const named = attributes.map((attribute) => ({ ...attribute, name: kNames[attribute.name] ?? attribute.name.toLowerCase() }));
      const of = (value) => Object.fromEntries(named.map((attribute) => [attribute.name, value(attribute)]));
      const geometry = await new Promise((resolve, reject) => this.#loader.decodeDracoFile(buffer, resolve,
        of(({ uniqueId }) => uniqueId), of(({ type }) => kArrays[type]), LinearSRGBColorSpace, reject));
      for (const { name, normalized } of named) if (geometry.attributes[name] !== undefined) geometry.attributes[name].normalized = normalized;
      return geometry;
    } catch (error) {
      throw this.#placed(error, primitive);
    }
  }
}
