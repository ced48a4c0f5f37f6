// psplit/gltf: a glTF asset as typed arrays, without a loader.
import type { Bytes, ComponentArray, ComponentType, Pool } from './index.js';

/** MeshoptDecoder of the npm package meshoptimizer, or the copy in three or Babylon.js. */
export interface MeshoptDecoderLike {
  readonly ready?: Promise<void>;
  decodeGltfBuffer(target: Uint8Array, count: number, size: number, source: Uint8Array, mode: string, filter?: string): void;
}

export interface AssetOptions {
  /** The pool whose workers decode. By default the calling thread decodes. */
  pool?: Pool;
  /**
   * Decodes buffer views with EXT_meshopt_compression or KHR_meshopt_compression, on the calling thread. Without it, assets that
   * need one of the two are `unsupported`.
   */
  meshoptDecoder?: MeshoptDecoderLike;
  /** Ends the job: its promise rejects with the code `aborted`. */
  signal?: AbortSignal;
}

export interface DecodedAccessor {
  type: ComponentType;
  componentCount: number;
  normalized: boolean;
  /** `componentCount` components for each point, tightly packed. */
  array: ComponentArray;
}

export interface DecodedPrimitive {
  /** The index of the mesh, and of the primitive in the mesh. */
  mesh: number;
  primitive: number;
  /** glTF's: 4 is a list of triangles. */
  mode: number;
  /** The index of the material, if it has one. */
  material?: number;
  /** How the asset stores its triangles: in patches, in stock Draco, or in buffer views. */
  coding: 'patches' | 'draco' | 'none';
  pointCount: number;
  /** In the accessor's type; null if the primitive has no indices. */
  indices: Uint8Array | Uint16Array | Uint32Array | null;
  /** Accessors by glTF's attribute names: POSITION, NORMAL, TEXCOORD_0 and so on. */
  attributes: Record<string, DecodedAccessor>;
  /** The accessors of each morph target, by attribute name; missing without morph targets. */
  targets?: Record<string, DecodedAccessor>[];
}

export interface DecodedAsset {
  /** The asset's whole JSON, with nodes, materials and the rest. */
  json: any;
  /** All primitives of all meshes, in their order. Primitives that share stored data may share arrays. */
  primitives: DecodedPrimitive[];
}

/**
 * Decodes all primitives of a GLB, or of the JSON of a .gltf: PSPLIT_mesh_draco_patches, KHR_draco_mesh_compression, uncompressed
 * ones, and buffer views compressed by meshoptimizer. Safe for untrusted bytes. If a compressed primitive cannot be decoded, its
 * fallback is read, unless the compressed data are invalid. Images and animations are not read. Errors name mesh and primitive.
 * @param options `url`: the asset's address, to which the addresses of its other files are relative
 */
export function decodeGlb(data: Bytes, options?: AssetOptions & { url?: string | URL }): Promise<DecodedAsset>;

/** Loads a .glb or .gltf with its other files, and decodes it as decodeGlb does. */
export function decodeGltf(url: string | URL, options?: AssetOptions): Promise<DecodedAsset>;
