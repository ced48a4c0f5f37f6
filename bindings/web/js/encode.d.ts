// psplit/encode: encodes meshes as containers of the glTF extension PSPLIT_mesh_draco_patches.
import type { ComponentArray, Configuration, PoolOptions } from './index.js';

export { PsplitError } from './index.js';

export interface AttributeToEncode {
  /** The values, which are stored in a type of glTF: integers of 8 or 16 bits, or floats. */
  array: Int8Array | Uint8Array | Uint8ClampedArray | Int16Array | Uint16Array | Uint32Array | Float32Array | ComponentArray;
  /** Components of each point, 1 to 16. The default is `itemSize`, the name in three's BufferAttribute. */
  componentCount?: number;
  itemSize?: number;
  normalized?: boolean;
}

/** A list of triangles: for example a primitive of decodeGlb (psplit/gltf). */
export interface MeshToEncode {
  /** Three point indices for each face. Without them, each three consecutive points are a face. */
  indices?: Uint8Array | Uint16Array | Uint32Array | null;
  /**
   * Attributes by glTF's names, including POSITION. The deltas of morph target 3 are named `targets/3/POSITION` and so on; their
   * ids belong in the extension's `targets`.
   */
  attributes: Record<string, AttributeToEncode>;
  /**
   * An equal number of bytes for each point. Points that differ in these bytes are not merged: for data beside the attributes,
   * which `sourcePoints` reorders for the encoded mesh.
   */
  distinct?: ArrayBufferView;
}

/** The options of `gltf-psplit encode`, with its defaults; see docs/manual.md. */
export interface EncodeOptions {
  /** The number of patches, of all meshes together. */
  patches?: number;
  /** The approximate number of faces in each patch. */
  patchFaces?: number;
  /** Meshes of fewer faces become one patch. By default 20,000, if neither `patches` nor `patchFaces` is given. */
  minFaces?: number;
  /**
   * The patches of a mesh without the options above: few (`size`), 2 to 16 or patches of 30,000 faces (`balanced`), or patches of
   * 4,800 faces (`speed`). With `size` and without `encodeSpeed`, each attribute of a patch gets the prediction with the fewest
   * bytes, and condensed patches get the smallest coding.
   */
  profile?: 'balanced' | 'speed' | 'size';
  /** Bits of each component of positions: 14 by default. `auto`: the fewest that the mesh's edges allow. */
  positionBits?: number | 'auto';
  /** The largest allowed error of a position, in place of `positionBits`. The mesh gets the fewest bits that keep it. */
  maxError?: number;
  normalBits?: number;
  texcoordBits?: number;
  colorBits?: number;
  genericBits?: number;
  /** Sets the step of morph targets to that of their base attribute with this number of bits. By default the base attribute's bits.
  */
  morphBits?: number;
  /** Keeps every float exactly. */
  lossless?: boolean;
  /** Names of attributes that are kept exactly. */
  exact?: string[];
  /** Draco's speed, from 0 (small) to 10 (fast): 5 by default. */
  encodeSpeed?: number;
  /** Condenses the patches: fewer bytes, for decoders that support condensed patches. */
  condense?: boolean;
  /** Stores the bounding box of each patch. */
  boxes?: boolean;
  /** The order of patches: as they were cut, the largest first, or the nearest to a point first. */
  order?: 'cut' | 'size' | { near: [number, number, number] };
  keepDuplicates?: boolean;
  keepDegenerate?: boolean;
  keepUnused?: boolean;
  /** Whether the container is decoded and compared with the mesh; the default is true. */
  verify?: boolean;
  /** Whether results include the decoded arrays. */
  decoded?: boolean;
  /** Called with the growing number of encoded faces and their total. In the last call, done equals total. */
  onProgress?: (done: number, total: number) => void;
  signal?: AbortSignal;
}

export interface MeshesOptions extends EncodeOptions {
  /**
   * A group number for each mesh. Meshes of a group share their quantization grids, so that common borders still meet. By default
   * all meshes are one group.
   */
  grids?: number[];
}

/** The request for an attribute from a decoder, and its stored precision. */
export interface EncodedAttribute {
  name: string;
  uniqueId: number;
  type: 'int8' | 'uint8' | 'int16' | 'uint16' | 'float32';
  componentCount: number;
  normalized: boolean;
  /** Bits of each component; 0 if the values are kept exactly, as always with values that no grid can hold (NaN, infinity). */
  bits: number;
  /** The decoded values, with the option `decoded`. */
  array?: ComponentArray;
}

export interface EncodedMesh {
  container: Uint8Array;
  /** Counts of the encoded mesh, without merged duplicates, degenerate faces and unused points. */
  faceCount: number;
  pointCount: number;
  /** The number of patches, without the residue. */
  patchCount: number;
  hasResidue: boolean;
  attributes: EncodedAttribute[];
  /** Three point indices for each face, if the option `decoded` is given. */
  indices?: Uint32Array;
  /** For each point of the encoded mesh, its index in the given mesh. */
  sourcePoints: Uint32Array;
  mergedPoints: number;
  droppedPoints: number;
  droppedFaces: number;
  /** Bytes of the tables that condensed patches share. */
  headBytes: number;
  /** The largest distance between a position and its decoded position. Missing without `verify`. */
  positionError?: number;
}

/** Encodes on the calling thread. The container equals that of `gltf-psplit encode --always-patches`, byte for byte. */
export function encodeMesh(mesh: MeshToEncode, options?: EncodeOptions): Promise<EncodedMesh>;
/** Encodes several meshes with common grids, such as the primitives of a glTF mesh. Errors state the index of the mesh. */
export function encodeMeshes(meshes: MeshToEncode[], options?: MeshesOptions): Promise<EncodedMesh[]>;

export interface PointsToEncode {
  /** Attributes by glTF's names, including POSITION. Arrays may be Uint32Arrays, too. */
  attributes: Record<string, AttributeToEncode>;
}

/** The options that apply to point clouds. */
export type PointsOptions = Pick<EncodeOptions, 'positionBits' | 'maxError' | 'normalBits' | 'texcoordBits' | 'colorBits' | 'genericBits' | 'lossless'
  | 'exact' | 'encodeSpeed' | 'verify' | 'decoded' | 'signal'>;

export interface EncodedPoints {
  /** A Draco point cloud, the content of a `.drc` file. */
  stream: Uint8Array;
  pointCount: number;
  attributes: (Omit<EncodedAttribute, 'type'> & { type: EncodedAttribute['type'] | 'uint32' })[];
  /** For each point of the stream, its index in the given points. A kD-tree reorders points. */
  sourcePoints: Uint32Array;
  positionError?: number;
}

/**
 * Encodes points without faces, on the calling thread, to the same bytes as libdraco: as a kD-tree, or sequentially, in the given
 * order, at `encodeSpeed` 10 or if floats are kept exactly. All points are kept.
 */
export function encodePoints(points: PointsToEncode, options?: PointsOptions): Promise<EncodedPoints>;

/**
 * Sets the places of `psplit_encoder.wasm` and `encode_worker.js`, if they are not beside the package's code. Omitted options are
 * reset to their defaults.
 */
export function configure(options: Omit<Configuration, 'condensedWasm'>): void;

export interface Transfer {
  /** Whether the mesh's arrays may be transferred to the worker, which leaves the caller's arrays empty. */
  transfer?: boolean;
}

/** Encodes in workers. `signal` stops a job at once. */
export interface Encoder {
  ready(): Promise<void>;
  encodePoints(points: PointsToEncode, options?: PointsOptions & Transfer): Promise<EncodedPoints>;
  encodeMesh(mesh: MeshToEncode, options?: EncodeOptions & Transfer): Promise<EncodedMesh>;
  encodeMeshes(meshes: MeshToEncode[], options?: MeshesOptions & Transfer): Promise<EncodedMesh[]>;
  /** Ends all workers. Unfinished jobs reject with the code `aborted`. */
  dispose(): void;
}

/** Creates an encoder, by default with one worker, which runs jobs one after the other. */
export function createEncoder(options?: Omit<PoolOptions, 'shared'>): Encoder;
