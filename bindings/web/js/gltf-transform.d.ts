// The extension PSPLIT_mesh_draco_patches for glTF-Transform 4.
import { Extension, type JSONDocument, type ReaderContext, type Transform, type WriterContext } from '@gltf-transform/core';
import type { EncodeOptions, Encoder } from './encode.js';
import type { AttributeRequest, Bytes, Configuration, DecodedContainer, Pool } from './index.js';

/** Decodes at once, on the calling thread. */
export interface SynchronousDecoder {
  decodeContainer(data: Bytes, options: { attributes: AttributeRequest[] }): DecodedContainer;
}

/** Compiles the module. What it resolves to is the dependency `psplit.decoder`. */
export function createDecoder(options?: Pick<Configuration, 'wasm'>): Promise<SynchronousDecoder>;

/**
 * Decodes all containers of a document in the workers of a pool, between `io.readAsJSON()` and `io.readJSON()`, which then
 * needs no decoder. Without it, `io.read()` decodes on the calling thread.
 */
export function decodeAhead(document: JSONDocument, pool: Pool, options?: { signal?: AbortSignal }): Promise<void>;

export interface PsplitOptions extends Omit<EncodeOptions, 'decoded'> {
  /** Encodes in its worker. By default the calling thread encodes. */
  encoder?: Encoder;
  /** Which primitives share a quantization grid: none (`primitive`), those of a mesh (the default), or all (`scene`).
   *  Then the grid is one that nodes move onto itself, if there is one; otherwise there is a warning. */
  quantizationVolume?: 'primitive' | 'mesh' | 'scene';
  /** Whether loaders have to know the extension. Otherwise the file has the geometry once more, uncompressed. By default true. */
  required?: boolean;
  /** As in `createDecoder`: a decoder compares containers with the document's geometry when it is written. */
  wasm?: Configuration['wasm'];
}

/**
 * A transform that makes patches of all lists of triangles, with the bytes of `gltf-psplit encode --always-patches`. The document then
 * has the geometry to which they decode. Morph targets are in patches, but for zeros and exact floats: these get the new order of
 * points. The logger says what is left as it is: points, lines, strips, and what is in patches already.
 */
export function psplit(options?: PsplitOptions): Transform;

/**
 * Reads containers. Writes those that were read, or made by psplit(), and whose geometry did not change since, byte for byte; other
 * geometry is written without compression, and the logger says why. If the extension is not required (`setRequired(false)`), the output also
 * has the uncompressed geometry, as a fallback, unless the mesh has coarse primitives. These are kept, but for extensions on them,
 * while the mesh has a container.
 */
export class PsplitMeshDracoPatches extends Extension {
  static readonly EXTENSION_NAME: 'PSPLIT_mesh_draco_patches';
  readonly extensionName: 'PSPLIT_mesh_draco_patches';
  read(context: ReaderContext): this;
  write(context: WriterContext): this;
}
