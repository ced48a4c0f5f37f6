// psplit/encode: encodes meshes as containers of the glTF extension PSPLIT_mesh_draco_patches.
import type { ComponentArray, Configuration, PoolOptions } from './index.js';

export { PsplitError } from './index.js';

export interface AttributeToEncode {
  /** Of the types that glTF has: of 8 and 16 bits, or floats. */
  array: Int8Array | Uint8Array | Uint8ClampedArray | Int16Array | Uint16Array | Uint32Array | Float32Array | ComponentArray;
  /** Components of a point, 1 to 16. Without it `itemSize` is taken, as three's BufferAttribute calls it. */
  componentCount?: number;
  itemSize?: number;
  normalized?: boolean;
}

/** A list of triangles: for example a primitive of decodeGlb (psplit/gltf). */
export interface MeshToEncode {
  /** Three numbers of points for each face. Without them, each three points are a face. */
  indices?: Uint8Array | Uint16Array | Uint32Array | null;
  /**
   * By glTF's names. POSITION is one of them. The deltas of morph target 3 may be `targets/3/POSITION` and so on; their ids go in
   * the extension's `targets`.
   */
  attributes: Record<string, AttributeToEncode>;
  /**
   * As many bytes for each point. Points that differ in them are not merged: for data beside the attributes, which `sourcePoints`
   * puts in the order of the encoded mesh.
   */
  distinct?: ArrayBufferView;
}

/** The options of `gltf-psplit encode`, with its defaults: docs/manual.md. */
export interface EncodeOptions {
  /** The number of patches, of all meshes together. */
  patches?: number;
  /** Faces of a patch, about. */
  patchFaces?: number;
  /** Meshes of fewer faces are one patch: by default of fewer than 20,000, if neither `patches` nor `patchFaces` is given. */
  minFaces?: number;
  /**
   * How many patches a mesh gets otherwise: few (`size`), 2 to 16 or of 30,000 faces (`balanced`), or of 4,800 faces (`speed`). With
   * `size` and without `encodeSpeed`, each attribute of a patch gets the prediction of fewest bytes, and condensed patches the smallest
   * coding.
   */
  profile?: 'balanced' | 'speed' | 'size';
  /** Bits of each component of positions: 14 by default. `auto`: as few as the mesh's edges allow. */
  positionBits?: number | 'auto';
  /** In place of `positionBits`: the fewest bits for which no position is farther off. */
  maxError?: number;
  normalBits?: number;
  texcoordBits?: number;
  colorBits?: number;
  genericBits?: number;
  /** Of morph targets, as if they were as wide as the attribute that they change. By default its bits. */
  morphBits?: number;
  /** Keeps every float exactly. */
  lossless?: boolean;
  /** Names of attributes that are kept exactly. */
  exact?: string[];
  /** Draco's speed, from 0 (small) to 10 (fast): 5 by default. */
  encodeSpeed?: number;
  /** Condenses the patches: fewer bytes, for decoders that know it. */
  condense?: boolean;
  /** Stores the boxes of patches. */
  boxes?: boolean;
  /** The order of patches: as they were cut, the largest first, or the nearest to a point first. */
  order?: 'cut' | 'size' | { near: [number, number, number] };
  keepDuplicates?: boolean;
  keepDegenerate?: boolean;
  keepUnused?: boolean;
  /** Compares what the container decodes to with the mesh. By default true. */
  verify?: boolean;
  /** Whether results have the arrays that the container decodes to. */
  decoded?: boolean;
  /** Called with the number of encoded faces, which grows, and their total. The last call has done = total. */
  onProgress?: (done: number, total: number) => void;
  signal?: AbortSignal;
}

export interface MeshesOptions extends EncodeOptions {
  /**
   * A number for each mesh. Meshes of one number share their quantization grids, so that borders that meet still meet. By default
   * all do.
   */
  grids?: number[];
}

/** How an attribute is requested from a decoder, and how it is stored. */
export interface EncodedAttribute {
  name: string;
  uniqueId: number;
  type: 'int8' | 'uint8' | 'int16' | 'uint16' | 'float32';
  componentCount: number;
  normalized: boolean;
  /** Bits of a component; 0 if the values are kept exactly, as those are that no grid can hold (NaN, infinity). */
  bits: number;
  /** With the option `decoded`. */
  array?: ComponentArray;
}

export interface EncodedMesh {
  container: Uint8Array;
  /** Of the encoded mesh: duplicate points are merged, and what draws nothing is dropped. */
  faceCount: number;
  pointCount: number;
  /** Without the residue. */
  patchCount: number;
  hasResidue: boolean;
  attributes: EncodedAttribute[];
  /** With the option `decoded`: three numbers of points for each face. */
  indices?: Uint32Array;
  /** For each point of the encoded mesh, the point of the given mesh that it was. */
  sourcePoints: Uint32Array;
  mergedPoints: number;
  droppedPoints: number;
  droppedFaces: number;
  /** Bytes of what condensed patches share. */
  headBytes: number;
  /** The largest distance of a position from where it was. Missing if it was not verified. */
  positionError?: number;
}

/** Encodes on the calling thread. The container is that of `gltf-psplit encode --always-patches`, byte for byte. */
export function encodeMesh(mesh: MeshToEncode, options?: EncodeOptions): Promise<EncodedMesh>;
/** Encodes several meshes with common grids, as the primitives of a glTF mesh. Errors name the number of the mesh. */
export function encodeMeshes(meshes: MeshToEncode[], options?: MeshesOptions): Promise<EncodedMesh[]>;

export interface PointsToEncode {
  /** By glTF's names. POSITION is one of them. Uint32Arrays may be among them. */
  attributes: Record<string, AttributeToEncode>;
}

/** What a point cloud has no part in is left out. */
export type PointsOptions = Pick<EncodeOptions, 'positionBits' | 'maxError' | 'normalBits' | 'texcoordBits' | 'colorBits' | 'genericBits' | 'lossless'
  | 'exact' | 'encodeSpeed' | 'verify' | 'decoded' | 'signal'>;

export interface EncodedPoints {
  /** A Draco point cloud, as a `.drc` file has it. */
  stream: Uint8Array;
  pointCount: number;
  attributes: (Omit<EncodedAttribute, 'type'> & { type: EncodedAttribute['type'] | 'uint32' })[];
  /** For each point of the stream, the given point that it was. A kD-tree has an order of its own. */
  sourcePoints: Uint32Array;
  positionError?: number;
}

/**
 * Encodes points without faces, on the calling thread, to the bytes of libdraco's encoder: as a kD-tree, or at `encodeSpeed` 10, and
 * with floats that are exact, sequentially, in their order. All points are kept.
 */
export function encodePoints(points: PointsToEncode, options?: PointsOptions): Promise<EncodedPoints>;

/**
 * Says where `psplit_encoder.wasm` and `encode_worker.js` are, if not beside the package's code. An option that is left out has its
 * default again.
 */
export function configure(options: Omit<Configuration, 'condensedWasm'>): void;

export interface Transfer {
  /** Whether the mesh's arrays may be transferred to the worker: the caller's are then empty. */
  transfer?: boolean;
}

/** Encodes in workers. `signal` ends a job at once. */
export interface Encoder {
  ready(): Promise<void>;
  encodePoints(points: PointsToEncode, options?: PointsOptions & Transfer): Promise<EncodedPoints>;
  encodeMesh(mesh: MeshToEncode, options?: EncodeOptions & Transfer): Promise<EncodedMesh>;
  encodeMeshes(meshes: MeshToEncode[], options?: MeshesOptions & Transfer): Promise<EncodedMesh[]>;
  /** Ends all workers. Jobs that are not done reject with the code `aborted`. */
  dispose(): void;
}

/** By default one worker, which does the jobs one after the other. */
export function createEncoder(options?: Omit<PoolOptions, 'shared'>): Encoder;
