// Decodes Draco streams, and the containers of the glTF extension PSPLIT_mesh_draco_patches.

export type ComponentType = 'int8' | 'uint8' | 'int16' | 'uint16' | 'int32' | 'uint32' | 'int64' | 'uint64' | 'float32' |
  'float64' | 'bool';
/**
 * The array of a component type. The rare int64 and uint64 attributes, which only Draco streams have, are in a BigInt64Array or
 * BigUint64Array, to which the caller must cast.
 */
export type ComponentArray = Int8Array | Uint8Array | Int16Array | Uint16Array | Int32Array | Uint32Array | Float32Array |
  Float64Array;

/** A request for an attribute of a Draco stream, by its unique id or its semantic. */
export interface DracoAttributeRequest {
  uniqueId?: number;
  /** Chooses the first attribute of this semantic, in place of `uniqueId`. The result leaves it out if the stream has none. */
  semantic?: 'POSITION' | 'NORMAL' | 'COLOR' | 'TEX_COORD' | 'GENERIC';
  /** The name in messages and in the result. The default is Draco's semantic: POSITION, NORMAL, COLOR, TEX_COORD or GENERIC. */
  name?: string;
  /** The type of the result. The default is the type that the stream stores. */
  type?: ComponentType;
}

/**
 * A request for an attribute of a container. The unique ids are in the extension's `attributes` and `targets`, the rest in the
 * accessors.
 */
export interface AttributeRequest {
  /** glTF's name. The deltas of a morph target have names such as `targets/3/POSITION`, also in results. */
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
  /** Three point indices for each face. */
  indices: Uint32Array;
  attributes: DecodedAttribute[];
}

/** The counts of a container's mesh. */
export interface ContainerCounts {
  faceCount: number;
  pointCount: number;
  /** The number of patches, without the residue. */
  patchCount: number;
  /** Whether a residue follows the patches: faces and points that no patch can carry. Below it counts as one more patch. */
  hasResidue: boolean;
  /** Whether patches share tables; otherwise each is a Draco stream. */
  isCondensed: boolean;
  /**
   * The boxes of the patches, if the container has them (`gltf-psplit encode --boxes`): for each patch, and the residue, the
   * minimum x, y and z of its positions, then the maximum. If a minimum exceeds its maximum, the patch has no finite positions.
   */
  boxes?: Float64Array;
}

export interface DecodedContainer extends DecodedMesh, ContainerCounts {
  /** Patch i has the faces from `firstFaces[i]` to `firstFaces[i + 1]`. The last number is the count of faces. */
  firstFaces: Uint32Array;
  /** Patch i owns the points from `firstPoints[i]` to `firstPoints[i + 1]`. Its faces also use points of earlier patches. */
  firstPoints: Uint32Array;
}

/**
 * Some consecutive patches of a mesh. Faces and points are numbered as in the mesh: the part has `indices.length / 3` faces from
 * `firstFace` on, and `pointCount` points from `firstPoint` on. A receiver copies them to these places in its arrays, in any order
 * of the parts: at any time, the faces refer only to points that have arrived.
 *
 * A part that is not final lacks some faces, between patches that different workers decode. Their three indices are 0. Its patches
 * arrive again in a final part. All final parts together are the mesh, each patch once.
 */
export interface DecodedPart {
  /** The index of the first patch, and one past the last. */
  patches: [first: number, end: number];
  isFinal: boolean;
  firstFace: number;
  /** As in DecodedContainer, but of these patches only; starts with `firstFace`. */
  firstFaces: Uint32Array;
  /** Three indices of the mesh's points for each face. */
  indices: Uint32Array;
  firstPoint: number;
  pointCount: number;
  /** The values of the part's points. Arrays of a part may be views of the result's arrays. */
  attributes: DecodedAttribute[];
}

export type Bytes = ArrayBuffer | ArrayBufferView | SharedArrayBuffer;

/** The error with which all promises of this package reject. */
export class PsplitError extends Error {
  /** `unsupported`: for example a Draco bitstream that is older than 2.2. */
  code: 'invalid-input' | 'unsupported' | 'out-of-memory' | 'aborted' | 'failed';
  /** The index of the patch in its container; undefined if the error is not in one patch. */
  patch?: number;
  /** The indices of the mesh and primitive in the glTF file, if the error is in one primitive. */
  mesh?: number;
  primitive?: number;
}

export interface Configuration {
  /** The WebAssembly module, its bytes or its address. The default is `psplit.wasm` beside the package's code. */
  wasm?: WebAssembly.Module | BufferSource | string | URL;
  /**
   * Likewise for `psplit_condensed.wasm`, which is loaded for the first container with condensed patches. It can also replace
   * `psplit.wasm`: given as `wasm`, it is the only module.
   */
  condensedWasm?: WebAssembly.Module | BufferSource | string | URL;
  /**
   * The address of `worker.js`, or a function that starts it as a worker: a module `Worker`, in Node.js a Worker of
   * node:worker_threads. The default is `worker.js` beside the package's code.
   */
  worker?: string | URL | (() => unknown);
}

/**
 * Sets the files that the package loads, for functions on the calling thread and for pools created later. Needed where files beside
 * the code cannot be fetched, as in edge runtimes. Omitted options are reset to their defaults.
 */
export function configure(options: Configuration): void;

/**
 * Loads and compiles the WebAssembly module, which otherwise happens at the first decoding: with `condensed` the one that also decodes
 * condensed patches, which then decodes all.
 */
export function ready(options?: { condensed?: boolean }): Promise<void>;

/**
 * Decodes a Draco 2.2 mesh stream on the calling thread, by default all attributes in the stored types. Results equal libdraco's
 * bit for bit. Safe for untrusted bytes.
 */
export function decodeDraco(data: Bytes, options?: { attributes?: DracoAttributeRequest[] }): Promise<DecodedMesh>;

/**
 * Decodes a container on the calling thread, and stitches its patches to one mesh. Safe for untrusted bytes. By default it decodes
 * all attributes of the first patch, in their stored types, with the names that decodeDraco gives them; the first patch is then
 * decoded twice.
 */
export function decodeContainer(data: Bytes, options?: { attributes?: AttributeRequest[] }): Promise<DecodedContainer>;

export interface PoolOptions extends Configuration {
  /** The maximum number of workers. By default the number of processors, but at most 4. */
  workers?: number;
  /** How long idle workers are kept, in milliseconds; the default is 10,000. */
  idleMs?: number;
  /**
   * Whether several workers may write a mesh to shared memory, which saves assembling it. The result's arrays then use a
   * SharedArrayBuffer. By default true in pages that are cross-origin isolated, and false in Node.js. Pages that are not isolated
   * have no shared memory, and need none.
   */
  shared?: boolean;
  /**
   * Whether the calling thread decodes if no worker can be started: because a policy forbids it, the page has another origin than
   * the package, or workers do not exist. A warning on the console then says why. The default is true. If false, jobs reject with the
   * code `failed` in this case.
   */
  mainThread?: boolean;
}

export interface JobOptions {
  /** Stops the job: its promise rejects with the code `aborted`. */
  signal?: AbortSignal;
  /** Whether the data's buffer may be transferred to the worker, which leaves the caller's buffer empty. */
  transfer?: boolean;
}

export interface ContainerOptions extends JobOptions {
  attributes?: AttributeRequest[];
  /** Called with the growing number of decoded patches and their total. In the last call, done equals total. */
  onProgress?: (done: number, total: number) => void;
  /**
   * The number of workers that share the container's patches, if the pool has them. By default it follows from the container's
   * size: one for small containers.
   */
  workers?: number;
}

export interface StreamOptions extends Omit<ContainerOptions, 'transfer'> {
  /** Called with patches once they are decoded, as by decodePatches. */
  onPart?: (part: DecodedPart, mesh: ContainerCounts) => void;
}

/** A primitive of a glTF file, by the index of its mesh and its index in the mesh. */
export interface PrimitivePlace {
  mesh: number;
  primitive: number;
}

/** The argument of `choose`, known when a container's head has arrived. Arrays have one element for each patch, boxes six. */
export interface PatchChoice extends Partial<PrimitivePlace> {
  patchCount: number;
  byteLengths: Uint32Array;
  faceCounts: Uint32Array;
  /** As in ContainerCounts. */
  boxes?: Float64Array;
}

/**
 * Chooses patches of a container by their indices. They are fetched and decoded in the returned order. Undefined or null chooses
 * the whole mesh.
 */
export type ChoosePatches = (container: PatchChoice) =>
  Iterable<number> | null | undefined | void | Promise<Iterable<number> | null | undefined | void>;

/** Added to meshes whose patches were chosen. */
export interface ChosenPatches {
  /** The indices that `choose` returned: patch i of the mesh is patch `chosen[i]` of the container. */
  chosen?: Uint32Array;
}

/** The patches of which a mesh was made. If patches were chosen, only these count. */
export interface PatchFacts extends ChosenPatches {
  /** The size of the whole container. */
  bytes: number;
  patchCount: number;
  hasResidue: boolean;
  /** What decoded the mesh. */
  way: 'gpu' | 'wasm';
  /** Why the GPU did not, with the option `gpu` of psplit/three or psplit/babylon. */
  why?: string;
  /** Whether patches share tables; otherwise each is a Draco stream. */
  isCondensed: boolean;
  faceCount: number;
  pointCount: number;
  /** Stream i (a patch, or the residue at the end) has the faces from `firstFaces[i]` up to `firstFaces[i + 1]`, exclusive. */
  firstFaces: Uint32Array;
}

export interface UrlOptions extends Omit<StreamOptions, 'onPart'> {
  /** Counts the patches of all containers that have begun to arrive. */
  onProgress?: (done: number, total: number) => void;
  /** `place`: the first primitive that has the container. Without numbers, if the file is a container alone. */
  onPart?: (part: DecodedPart, mesh: ContainerCounts & ChosenPatches, place: Partial<PrimitivePlace>) => void;
  /**
   * Leaves patches out. The mesh then consists of the chosen patches only, in the chosen order, and counts only these. They share
   * no points: each patch has its own copy of points at borders, and each corner of a face keeps its values of the whole mesh. A
   * residue, which draws nothing, is left out. Errors state the patch's index in the container. Rules of the container that concern
   * omitted patches are not checked.
   *
   * If the server sends ranges of the file, and an ETag or a Last-Modified, other patches are not fetched. (Patches of `gltf-psplit
   * encode --condense` may need earlier patches, which are fetched as well.) If the file changes meanwhile, the promise rejects
   * with the code `failed`. From other servers, and from a given Response, the file is read up to the last byte that is needed.
   */
  choose?: ChoosePatches | null;
}

/**
 * The result of decodeUrl. Its primitives have the form that decodeContainer returns. (decodeGltf of psplit/gltf also returns
 * primitives that are not in patches, with attributes by name, once the whole file is loaded.)
 */
export interface DecodedFile {
  /** The JSON of a glTF file; null for a container file. */
  json: any;
  /**
   * In the order of meshes and primitives; for a container file, the one mesh without indices. Equal primitives share their
   * arrays.
   */
  primitives: (DecodedContainer & ChosenPatches & Partial<PrimitivePlace>)[];
}

/**
 * Decodes in workers. Jobs run in parallel. A large container takes several idle workers; the result does not depend on their
 * number. If a callback throws, the job's promise rejects with the thrown value.
 */
export interface Pool {
  /** The number of running workers; 0 while the calling thread decodes in their place. */
  readonly workerCount: number;
  ready(options?: { condensed?: boolean }): Promise<void>;
  decodeDraco(data: Bytes, options?: { attributes?: DracoAttributeRequest[] } & JobOptions): Promise<DecodedMesh>;
  decodeContainer(data: Bytes, options?: ContainerOptions): Promise<DecodedContainer>;
  /**
   * As decodeContainer, but also calls onPart with patches as they are decoded, all before the promise resolves. `mesh` has the
   * counts of the whole mesh.
   */
  decodePatches(data: Bytes, options: ContainerOptions & { onPart: (part: DecodedPart, mesh: ContainerCounts) => void }): Promise<DecodedContainer>;
  /**
   * Decodes a container whose bytes arrive in order, in chunks of any length: patches are decoded as soon as their bytes have
   * arrived. An error or an abort cancels the stream. One worker decodes, unless all bytes arrive before it is free.
   */
  decodeStream(stream: ReadableStream<Uint8Array> | AsyncIterable<Uint8Array>, options?: StreamOptions): Promise<DecodedContainer>;
  /**
   * Fetches a file, and decodes all its primitives in patches while it arrives: a GLB, a glTF file with its buffers, or a
   * container alone, for which `attributes` may be given. A glTF file's other primitives are left out. `url` may be a fetched
   * Response. An abort also stops the download. Errors have the indices of the mesh and the primitive in `mesh` and `primitive`.
   */
  decodeUrl(url: string | URL | Request | Response, options?: UrlOptions): Promise<DecodedFile>;
  /** Ends all workers. Unfinished jobs reject with the code `aborted`. */
  dispose(): void;
}

export function createPool(options?: PoolOptions): Pool;
