// The extension PSPLIT_mesh_draco_patches for Babylon.js' glTF loader, and psplit as its decoder of stock Draco.
import type { ChoosePatches, ChosenPatches, ContainerCounts, DecodedPart, Pool } from './index.js';

export interface BabylonOptions {
  /** Decodes. By default a pool that all loaders share, which ends its workers when they are idle. */
  pool?: Pool;
  /**
   * Whether psplit also decodes lists of triangles in KHR_draco_mesh_compression, which is the default: Babylon.js then loads no decoder
   * for them. Bitstreams older than 2.2 need `false`, which leaves all of them to Babylon.js.
   */
  draco?: boolean;
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

export interface BabylonStreamingOptions {
  /** Ends the download, the load and decoding, which reject with the code `aborted`. */
  signal?: AbortSignal;
  /** Of each container: its decoded patches, and their total. */
  onProgress?: (done: number, total: number) => void;
  /**
   * Whether meshes are shown while their patches arrive, which is the default. The load then resolves when each mesh has its first
   * patches. Meshes have their final size, and gain triangles until `whole` resolves. Do not copy or change their geometry before.
   * Meshes with stored weights of a skin, or with morph targets, arrive whole.
   */
  patchByPatch?: boolean;
  /** The patches of a container, when they have arrived and are decoded; with `patchByPatch`, when the mesh has them. */
  onPart?: (part: DecodedPart, mesh: ContainerCounts & ChosenPatches) => void;
  /**
   * Leaves patches out, as in `decodeUrl` of psplit. The mesh then has the chosen patches alone, in their order; its bounds are those
   * of the whole mesh. It is not called for primitives with morph targets or attributes that are not in patches: these are whole.
   */
  choose?: ChoosePatches | null;
  /** Others are Babylon.js' own. */
  [option: string]: unknown;
}

/**
 * Loads a GLB or glTF file in patches, which are decoded while the file arrives. `load` is LoadAssetContainerAsync,
 * ImportMeshAsync or AppendSceneAsync of Babylon.js; call registerPsplit before. Resolves to what `load` does, with `psplit`: its
 * `whole` resolves when all meshes are whole, and rejects if one cannot be; none of its triangles are shown then.
 */
export function loadStreaming<Scene, Result>(load: (source: string, scene: Scene, options?: any) => Promise<Result>, url: string,
  scene: Scene, options?: BabylonStreamingOptions): Promise<Result & { psplit: { whole: Promise<void> } }>;
