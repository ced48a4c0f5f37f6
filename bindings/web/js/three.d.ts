// Adapters for three.js: PSPLIT_mesh_draco_patches in GLTFLoader, and psplit in place of DRACOLoader.
import type { BufferGeometry, Loader, LoadingManager, Object3D } from 'three';
import type { GLTF, GLTFLoader, GLTFLoaderPlugin } from 'three/addons/loaders/GLTFLoader.js';
import type { ChoosePatches, DecodedPart, PatchFacts, Pool } from './index.js';

export type { PatchFacts } from './index.js';

declare module 'three/addons/loaders/GLTFLoader.js' {
  interface GLTF {
    /** Set only if a PsplitPlugin was registered. */
    psplit: PsplitPlugin;
  }
}

/** The members of a GLTFParser, of three or three-stdlib, that the plugin uses. */
export interface PsplitParser {
  json: any;
  options: { path: string; manager: LoadingManager };
  associations: Map<any, { meshes?: number; primitives?: number }>;
  getDependency(type: string, index: number): Promise<any>;
}

export interface PsplitPluginOptions {
  /** The pool that decodes. By default all plugins of the page share one. */
  pool?: Pool;
  /**
   * Stops decoding, and with loadStreaming also the download. The load rejects with the code `aborted`. `LoadingManager.abort()`
   * has the same effect.
   */
  signal?: AbortSignal;
  /**
   * Called while patches are decoded, with the number of decoded patches and the total of all containers whose decoding has begun.
   * The last argument is the primitive (the first one, if several share the container).
   */
  onProgress?(done: number, total: number, primitive: { mesh: number; primitive: number }): void;
  /**
   * Whether meshes are shown while their patches arrive. The loader then resolves when each mesh has its first patches. The
   * geometries have their final size, and gain triangles until `whole` resolves. Draw again on each `onProgress`. Do not
   * copy or change the geometries before `whole`. Meshes with stored skin weights, or with morph targets in patches, arrive whole.
   */
  patchByPatch?: boolean;
  /** With `patchByPatch`: called when the patches of a part have been written to the geometry. */
  onPart?(part: DecodedPart, primitive: { mesh: number; primitive: number }): void;
  /**
   * With loadStreaming: leaves patches out, as in `decodeUrl` of psplit. The geometry then has only the chosen patches, in the
   * chosen order, but the file states the bounds of the whole mesh. `choose` is not called for primitives that have morph targets
   * or attributes outside of their patches; these primitives load whole.
   */
  choose?: ChoosePatches | null;
  /**
   * Decodes primitives in KHR_draco_mesh_compression: a PsplitDracoLoader or three's DRACOLoader. By default psplit decodes them in the
   * pool; with loadStreaming, the GLTFLoader's DRACOLoader does, if it has one. `false` leaves them to the GLTFLoader, which then needs
   * a DRACOLoader. Bitstreams older than 2.2 need three's DRACOLoader, here or as a PsplitDracoLoader's `fallback`.
   */
  dracoLoader?: Loader<BufferGeometry> | false;
  /**
   * A WebGPURenderer of three, with which the meshes will be drawn: containers are decoded by shaders on its device, and the geometries have
   * the buffers that these write, without a copy. Only the renderer can read them (`renderer.getArrayBufferAsync(attribute)`): the arrays
   * of the attributes are empty, so raycasting, and cloning or merging geometries, do not work. Skinned meshes, morph targets, chosen
   * patches and containers that the shaders do not decode, and all if the renderer has no WebGPU, are decoded as without this option;
   * `patchesOf` says which way a mesh took, and why. Meshes that the GPU decodes arrive whole.
   */
  gpu?: { readonly backend: object; init?(): Promise<unknown> } | null;
  /** The name of the file, for errors. By default the loader's path, which lacks the name of a GLB. */
  file?: string;
}

/**
 * Decodes PSPLIT_mesh_draco_patches and KHR_draco_mesh_compression in GLTFLoader, which then needs no DRACOLoader:
 *
 *     loader.register((parser) => new PsplitPlugin(parser, { pool }));
 *
 * Each primitive becomes one mesh. Errors have the indices of the mesh and the primitive in `mesh` and `primitive`, and the
 * decoder's error in `cause`. The result of the load has the plugin in `psplit`.
 */
export class PsplitPlugin implements GLTFLoaderPlugin {
  constructor(parser: PsplitParser, options?: PsplitPluginOptions);
  readonly name: 'PSPLIT_mesh_draco_patches';
  /** Resolves when all meshes are whole. Rejects if one fails; none of that mesh's triangles are shown then. */
  readonly whole: Promise<void>;
  /** The patches of a mesh of the result; null if it was not made of patches, or is not yet whole. */
  patchesOf(mesh: Object3D): PatchFacts | null;
  beforeRoot(): Promise<void>;
  loadMesh(index: number): null;
  extendMaterialParams(): Promise<void>;
  loadBufferView(index: number): Promise<ArrayBuffer> | null;
  afterRoot(gltf: object): null;
}

/**
 * Loads a GLB or glTF file while its bytes arrive, with the loader's settings: meshes gain triangles patch by patch from the first
 * bytes on. Resolves when each mesh has its first patches and all textures are loaded.
 *
 *     const { scene, psplit } = await loadStreaming(new GLTFLoader(), '/model.glb', { onProgress: draw });
 *     await psplit.whole;
 *
 * The loader needs no plugin for this. `patchByPatch` is true by default. `signal` also stops the download. (GLTFLoader's own
 * `load` reads a GLB to its end before a plugin sees it.)
 */
export function loadStreaming(loader: GLTFLoader, url: string, options?: PsplitPluginOptions): Promise<GLTF>;

export interface PsplitDracoLoaderOptions {
  manager?: LoadingManager;
  /** The pool that decodes. By default the loader has its own, which `dispose` ends. */
  pool?: Pool;
  /** A loader, such as a DRACOLoader, for streams that psplit does not support: point clouds, bitstreams older than 2.2. */
  fallback?: Loader<BufferGeometry> | { decodeGeometry(buffer: ArrayBuffer, task: object): Promise<BufferGeometry> };
}

/**
 * Has the interface of three's DRACOLoader. GLTFLoader takes it so:
 *
 *     loader.setDRACOLoader(new PsplitDracoLoader({ pool }));
 */
export class PsplitDracoLoader extends Loader<BufferGeometry> {
  constructor(options?: PsplitDracoLoaderOptions | LoadingManager);
  readonly pool: Pool;
  fallback: PsplitDracoLoaderOptions['fallback'] | null;
  defaultAttributeIDs: Record<string, string>;
  defaultAttributeTypes: Record<string, string>;
  /** Does nothing: the decoder is found beside the package's code. */
  setDecoderPath(path: string | object): this;
  /**
   * Does nothing.
   * @deprecated as in three's DRACOLoader
   */
  setDecoderConfig(config: object): this;
  /** Sets the maximum number of workers of the loader's own pool. Call it before decoding. */
  setWorkerLimit(limit: number): this;
  preload(): this;
  load(url: string, onLoad?: (geometry: BufferGeometry) => void, onProgress?: (event: ProgressEvent) => void,
    onError?: (error: any) => void): void;
  /** Decodes a .drc file. Its colours are taken as sRGB, as by DRACOLoader. */
  parse(buffer: ArrayBuffer, onLoad: (geometry: BufferGeometry) => void, onError?: (error: unknown) => void): void;
  decodeDracoFile(buffer: ArrayBuffer, callback: (geometry: BufferGeometry) => void, attributeIDs?: Record<string, number> | null,
    attributeTypes?: Record<string, string> | null, vertexColorSpace?: string, onError?: (error: unknown) => void): Promise<void>;
  decodeGeometry(buffer: ArrayBuffer, task: { attributeIDs: Record<string, number | string>; attributeTypes: Record<string, string>;
    useUniqueIDs: boolean; vertexColorSpace: string }): Promise<BufferGeometry>;
  dispose(): this;
}
