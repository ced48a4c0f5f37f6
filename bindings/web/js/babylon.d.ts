// The extension PSPLIT_mesh_draco_patches for Babylon.js' glTF loader, and psplit as its decoder of stock Draco.
import type { ChoosePatches, ChosenPatches, ContainerCounts, DecodedPart, PatchFacts, Pool } from './index.js';

export type { PatchFacts } from './index.js';

export interface BabylonOptions {
  /** The pool that decodes. By default all loaders share a pool, which ends its workers when they are idle. */
  pool?: Pool;
  /**
   * Whether psplit also decodes lists of triangles in KHR_draco_mesh_compression, so that Babylon.js loads no decoder for them. The
   * default is true. Bitstreams older than 2.2 need `false`, which leaves all Draco streams to Babylon.js.
   */
  draco?: boolean;
  /**
   * With true and a WebGPUEngine, containers are decoded by shaders on the engine's device, and meshes have the buffers that these write, without
   * a copy. Babylon.js then has no arrays of a mesh: picking, and reading, cloning or merging its data, do not work, nor does the engine make it
   * again if it loses its device. Skinned meshes, morph targets, chosen patches and containers that the shaders do not decode, and all with other
   * engines, are decoded as without this option; `patchesOf` says which way a mesh took, and why. Meshes that the GPU decodes arrive whole.
   */
  gpu?: boolean;
}

/**
 * The patches of which a mesh was made, once its load has resolved; null if it was made of none.
 * @param mesh Babylon.js' mesh, or an instance of one
 */
export function patchesOf(mesh: object): PatchFacts | null;

/**
 * Registers the extension for all loads that begin later. The first argument is Babylon.js' own function: `registerGLTFExtension`
 * of `@babylonjs/loaders/glTF/2.0`.
 *
 * Whole primitives are decoded in the pool's workers. If a container cannot be decoded, the load fails with its mesh,
 * primitive and patch; if the container is valid but unsupported and the asset has a fallback, the fallback is loaded instead.
 * Disposing the loader ends its jobs.
 */
export function registerPsplit(
  registerGLTFExtension: (name: string, isGLTFExtension: boolean, factory: (loader: any) => any) => void,
  options?: BabylonOptions): void;

export interface BabylonStreamingOptions {
  /** Stops the download, the load and decoding, which reject with the code `aborted`. */
  signal?: AbortSignal;
  /** Called for each container with the number of its decoded patches and their total. */
  onProgress?: (done: number, total: number) => void;
  /**
   * Whether meshes are shown while their patches arrive; the default is true. The load then resolves when each mesh has its first
   * patches. Meshes have their final size, and gain triangles until `whole` resolves. Do not copy or change their geometry before.
   * Meshes with stored skin weights or morph targets arrive whole.
   */
  patchByPatch?: boolean;
  /** Called with patches of a container once they are decoded; with `patchByPatch`, once they are in the mesh. */
  onPart?: (part: DecodedPart, mesh: ContainerCounts & ChosenPatches) => void;
  /**
   * Leaves patches out, as in `decodeUrl` of psplit. The mesh then has only the chosen patches, in the chosen order, and the bounds
   * of the whole mesh. It is not called for primitives whose morph targets or attributes are outside of the patches; these load
   * whole.
   */
  choose?: ChoosePatches | null;
  /** All other options are Babylon.js' own. */
  [option: string]: unknown;
}

/**
 * Loads a GLB or glTF file in patches, which are decoded while the file arrives. `load` is LoadAssetContainerAsync,
 * ImportMeshAsync or AppendSceneAsync of Babylon.js; call registerPsplit before. Resolves to the result of `load` with an
 * additional member `psplit`: `psplit.whole` resolves when all meshes are whole, and rejects if one fails; none of that mesh's
 * triangles are shown then.
 */
export function loadStreaming<Scene, Result>(load: (source: string, scene: Scene, options?: any) => Promise<Result>, url: string,
  scene: Scene, options?: BabylonStreamingOptions): Promise<Result & { psplit: { whole: Promise<void> } }>;
