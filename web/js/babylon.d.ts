// The extension PSPLIT_mesh_draco_patches for Babylon.js' glTF loader.
import type { Pool } from './index.js';

export interface BabylonOptions {
  /** Decodes. By default a pool that all loaders share, which ends its workers when they are idle. */
  pool?: Pool;
}

/**
 * Registers the extension for all loads that begin later. The first argument is Babylon.js' own function: `registerGLTFExtension`
 * of `@babylonjs/loaders/glTF/2.0`.
 *
 * Whole primitives are decoded in the pool's workers. If a container cannot be decoded, the load fails with its mesh,
 * primitive and patch; if it is not invalid and the asset has a fallback, the fallback is loaded instead. Disposing the
 * loader ends its jobs.
 */
export function registerPsplit(
  registerGLTFExtension: (name: string, isGLTFExtension: boolean, factory: (loader: any) => any) => void,
  options?: BabylonOptions): void;
