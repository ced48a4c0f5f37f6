// The extension PSPLIT_mesh_draco_patches for glTF-Transform 4.
import { Extension, type JSONDocument, type ReaderContext, type Transform, type WriterContext } from '@gltf-transform/core';
import type { EncodeOptions, Encoder } from './encode.js';
import type { AttributeRequest, Bytes, Configuration, DecodedContainer, Pool } from './index.js';

/** Decodes synchronously, on the calling thread. */
export interface SynchronousDecoder {
  decodeContainer(data: Bytes, options: { attributes: AttributeRequest[] }): DecodedContainer;
}

/** Compiles the module, and resolves to the dependency `psplit.decoder`. */
export function createDecoder(options?: Pick<Configuration, 'wasm'>): Promise<SynchronousDecoder>;

/**
 * Decodes all containers of a document in the workers of a pool, between `io.readAsJSON()` and `io.readJSON()`, which then
 * needs no decoder. If you do not call this function, `io.read()` decodes on the calling thread.
 */
export function decodeAhead(document: JSONDocument, pool: Pool, options?: { signal?: AbortSignal }): Promise<void>;

export interface PsplitOptions extends Omit<EncodeOptions, 'decoded'> {
  /** The encoder whose worker encodes. By default the calling thread encodes. */
  encoder?: Encoder;
  /** Which primitives share a quantization grid: none (`primitive`), all of a mesh (the default), or all of the scene (`scene`).
   *  For `scene`, the grid is one that the nodes' transforms map onto itself; if none exists, a warning is logged. */
  quantizationVolume?: 'primitive' | 'mesh' | 'scene';
  /** Whether loaders must support the extension. If not, the file also contains the uncompressed geometry. The default is true. */
  required?: boolean;
  /** As in `createDecoder`: when the document is written, a decoder compares the containers with its geometry. */
  wasm?: Configuration['wasm'];
}

/**
 * Returns a transform that encodes all lists of triangles in patches, to the bytes of `gltf-psplit encode --always-patches`. The
 * document then has the decoded geometry. Patches include morph targets, except zeros and exact floats, which are only reordered.
 * The logger lists the primitives that are left as they are: points, lines, strips, and primitives that are in patches already.
 */
export function psplit(options?: PsplitOptions): Transform;

/**
 * Reads containers. Containers that were read, or made by psplit(), are written byte for byte if their geometry did not change
 * since; other geometry is written without compression, and the logger says why. If the extension is not required
 * (`setRequired(false)`), the output also has the uncompressed geometry, as a fallback, unless the mesh has coarse primitives.
 * Coarse primitives are kept, without their extensions, as long as the mesh has a container.
 */
export class PsplitMeshDracoPatches extends Extension {
  static readonly EXTENSION_NAME: 'PSPLIT_mesh_draco_patches';
  readonly extensionName: 'PSPLIT_mesh_draco_patches';
  read(context: ReaderContext): this;
  write(context: WriterContext): this;
}
