// The extension PSPLIT_mesh_draco_patches for glTF-Transform 4.
import { Extension, type JSONDocument, type ReaderContext, type WriterContext } from '@gltf-transform/core';
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

/**
 * Reads containers. Writes those that were read and whose geometry did not change since, byte for byte; other geometry is
 * written without compression, and the logger says why. If the extension is not required (`setRequired(false)`), the output also
 * has the uncompressed geometry, as a fallback, unless the mesh has coarse primitives. These are kept, but for extensions on them,
 * while the mesh has a container.
 */
export class PsplitMeshDracoPatches extends Extension {
  static readonly EXTENSION_NAME: 'PSPLIT_mesh_draco_patches';
  readonly extensionName: 'PSPLIT_mesh_draco_patches';
  read(context: ReaderContext): this;
  write(context: WriterContext): this;
}
