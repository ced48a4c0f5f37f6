// Decodes Draco streams, and the containers of the glTF extension PSPLIT_mesh_draco_patches.

export type ComponentType = 'int8' | 'uint8' | 'int16' | 'uint16' | 'int32' | 'uint32' | 'int64' | 'uint64' | 'float32' |
  'float64' | 'bool';
export type ComponentArray = Int8Array | Uint8Array | Int16Array | Uint16Array | Int32Array | Uint32Array | BigInt64Array |
  BigUint64Array | Float32Array | Float64Array;

/** An attribute of a Draco stream that is wanted, by its unique id or its semantic. */
export interface DracoAttributeRequest {
  uniqueId?: number;
  /** In place of `uniqueId`: the first attribute of this semantic. The result leaves it out if the stream has none. */
  semantic?: 'POSITION' | 'NORMAL' | 'COLOR' | 'TEX_COORD' | 'GENERIC';
  /** For messages, and for the result. By default Draco's semantic: POSITION, NORMAL, COLOR, TEX_COORD or GENERIC. */
  name?: string;
  /** The type of the result. By default the type that the stream stores. */
  type?: ComponentType;
}

/** An attribute of a container that is wanted: the extension's `attributes` have the unique ids, the accessors the rest. */
export interface AttributeRequest {
  name: string;
  uniqueId: number;
  type: 'int8' | 'uint8' | 'int16' | 'uint16' | 'uint32' | 'float32';
  componentCount: number;
  normalized?: boolean;
}

export interface DecodedAttribute {
  name: string;
  uniqueId: number;
  type: ComponentType;
  componentCount: number;
  normalized: boolean;
  /** `componentCount` components for each point. */
  array: ComponentArray;
}

export interface DecodedMesh {
  faceCount: number;
  pointCount: number;
  /** Three numbers of points for each face. */
  indices: Uint32Array;
  attributes: DecodedAttribute[];
}

export interface DecodedContainer extends DecodedMesh {
  /** Of the container: 1, 2 or 3. */
  version: number;
  patchCount: number;
  hasResidue: boolean;
}

export type Bytes = ArrayBuffer | ArrayBufferView | SharedArrayBuffer;

/** Every promise of this package that rejects, rejects with this error. */
export class PsplitError extends Error {
  /** `unsupported`: for example a Draco bitstream that is older than 2.2. */
  code: 'invalid-input' | 'unsupported' | 'out-of-memory' | 'aborted' | 'failed';
  /** The number of the patch in its container; undefined if the error is not one patch's. */
  patch?: number;
}

/** Loads and compiles the WebAssembly module, which the first call of a decoder does otherwise. */
export function ready(): Promise<void>;

/**
 * Decodes a Draco 2.2 mesh stream on the calling thread. By default all attributes, in the types that the stream stores.
 * The results are those of libdraco, bit for bit. Any bytes may be given.
 */
export function decodeDraco(data: Bytes, options?: { attributes?: DracoAttributeRequest[] }): Promise<DecodedMesh>;

/** Decodes a container on the calling thread, and stitches its patches to one mesh. Any bytes may be given. */
export function decodeContainer(data: Bytes, options: { attributes: AttributeRequest[] }): Promise<DecodedContainer>;

export interface PoolOptions {
  /** The most workers at a time. By default as many as the machine has processors, but no more than 4. */
  workers?: number;
  /** The WebAssembly module, its bytes or its address. By default `psplit.wasm` beside the package's code. */
  wasm?: WebAssembly.Module | BufferSource | string | URL;
  /** How long a worker without work goes on, in milliseconds. By default 10,000. */
  idleMs?: number;
}

export interface JobOptions {
  /** Ends the job: its promise rejects with the code `aborted`. */
  signal?: AbortSignal;
  /** Whether the data's buffer may be transferred to the worker: the caller's is then empty. */
  transfer?: boolean;
}

/** Decodes in workers. Jobs run side by side; each one runs on one worker. */
export interface Pool {
  readonly workerCount: number;
  ready(): Promise<void>;
  decodeDraco(data: Bytes, options?: { attributes?: DracoAttributeRequest[] } & JobOptions): Promise<DecodedMesh>;
  decodeContainer(data: Bytes, options: { attributes: AttributeRequest[] } & JobOptions): Promise<DecodedContainer>;
  /** Ends all workers. Jobs that are not done reject with the code `aborted`. */
  dispose(): void;
}

export function createPool(options?: PoolOptions): Pool;
