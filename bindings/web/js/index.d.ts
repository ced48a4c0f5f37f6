// Decodes Draco streams, and the containers of the glTF extension PSPLIT_mesh_draco_patches.

export type ComponentType = 'int8' | 'uint8' | 'int16' | 'uint16' | 'int32' | 'uint32' | 'int64' | 'uint64' | 'float32' |
  'float64' | 'bool';
/**
 * The array of a type. Only Draco streams have attributes of the types int64 and uint64, and hardly any has: their arrays are a
 * BigInt64Array or a BigUint64Array, to which the caller has to cast.
 */
export type ComponentArray = Int8Array | Uint8Array | Int16Array | Uint16Array | Int32Array | Uint32Array | Float32Array |
  Float64Array;

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

/**
 * An attribute of a container that is wanted: the extension's `attributes` and `targets` have the unique ids, the accessors the
 * rest.
 */
export interface AttributeRequest {
  /** glTF's. The deltas of a morph target have a name like `targets/3/POSITION`, also in results. */
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

/** What a container says of its mesh. */
export interface ContainerCounts {
  faceCount: number;
  pointCount: number;
  /** Without the residue. */
  patchCount: number;
  /** Whether a residue follows the patches: faces and points that no patch can carry. It counts as one more patch below. */
  hasResidue: boolean;
  /** Whether patches share tables; otherwise each is a Draco stream. */
  isCondensed: boolean;
  /**
   * The boxes of the patches, if the container has them (`gltf-psplit encode --boxes`): for each patch, and the residue, the least
   * x, y and z of its positions, and the greatest. If a least is above its greatest, there are no positions.
   */
  boxes?: Float64Array;
}

export interface DecodedContainer extends DecodedMesh, ContainerCounts {
  /** Patch i has the faces from `firstFaces[i]` to `firstFaces[i + 1]`. The last number is the count of faces. */
  firstFaces: Uint32Array;
  /** The same for points: each point belongs to one patch. Faces also use points of patches before theirs. */
  firstPoints: Uint32Array;
}

/**
 * Some consecutive patches of a mesh. The numbers of faces and points are the mesh's: the part has `indices.length / 3`
 * faces from `firstFace` on, and `pointCount` points from `firstPoint` on. A receiver copies them to these places of its
 * arrays, in any order of the parts: the faces then refer only to points that have come, at any time.
 *
 * A part that is not final lacks some faces, between patches that different workers decode. Their three indices are 0. Its
 * patches come once more, in a part that is final. All final parts together are the mesh, each patch once.
 */
export interface DecodedPart {
  /** The first patch, and the one after the last. */
  patches: [first: number, end: number];
  isFinal: boolean;
  firstFace: number;
  /** As in DecodedContainer, of these patches: the first number is `firstFace`. */
  firstFaces: Uint32Array;
  /** Three numbers of the mesh's points for each face. */
  indices: Uint32Array;
  firstPoint: number;
  pointCount: number;
  /** The values of the part's points. Arrays of a part may be views of the result's arrays. */
  attributes: DecodedAttribute[];
}

export type Bytes = ArrayBuffer | ArrayBufferView | SharedArrayBuffer;

/** Every promise of this package that rejects, rejects with this error. */
export class PsplitError extends Error {
  /** `unsupported`: for example a Draco bitstream that is older than 2.2. */
  code: 'invalid-input' | 'unsupported' | 'out-of-memory' | 'aborted' | 'failed';
  /** The number of the patch in its container; undefined if the error is not one patch's. */
  patch?: number;
  /** The numbers of the primitive in its glTF file, if the error is one primitive's. */
  mesh?: number;
  primitive?: number;
}

export interface Configuration {
  /** The WebAssembly module, its bytes or its address. By default `psplit.wasm` beside the package's code. */
  wasm?: WebAssembly.Module | BufferSource | string | URL;
  /**
   * The same of `psplit_condensed.wasm`, which is loaded when the first container with condensed patches comes. It decodes all that
   * `psplit.wasm` does: given as `wasm`, it is the only module.
   */
  condensedWasm?: WebAssembly.Module | BufferSource | string | URL;
  /**
   * The address of `worker.js`, or a function that makes a worker of it: a `Worker` that is a module, in Node.js one of
   * node:worker_threads. By default `worker.js` beside the package's code.
   */
  worker?: string | URL | (() => unknown);
}

/**
 * Says what the package loads: for the functions of the calling thread, and for pools that are made later. Needed where files
 * beside the code cannot be fetched, as in edge runtimes. An option that is left out has its default again.
 */
export function configure(options: Configuration): void;

/** Loads and compiles the WebAssembly module, which the first call of a decoder does otherwise. */
export function ready(): Promise<void>;

/**
 * Decodes a Draco 2.2 mesh stream on the calling thread. By default all attributes, in the types that the stream stores.
 * The results are those of libdraco, bit for bit. Any bytes may be given.
 */
export function decodeDraco(data: Bytes, options?: { attributes?: DracoAttributeRequest[] }): Promise<DecodedMesh>;

/**
 * Decodes a container on the calling thread, and stitches its patches to one mesh. Any bytes may be given. By default all
 * attributes of the first patch, in the types that it stores, with the names that decodeDraco gives them; the first patch
 * is then decoded twice.
 */
export function decodeContainer(data: Bytes, options?: { attributes?: AttributeRequest[] }): Promise<DecodedContainer>;

export interface PoolOptions extends Configuration {
  /** The most workers at a time. By default as many as the machine has processors, but no more than 4. */
  workers?: number;
  /** How long a worker without work goes on, in milliseconds. By default 10,000. */
  idleMs?: number;
  /**
   * Whether several workers may write a mesh to shared memory, which saves assembling it. The arrays of its result then have
   * a SharedArrayBuffer. By default true in pages that are cross-origin isolated, and false in Node.js. Pages that are not
   * isolated have no shared memory, and need none.
   */
  shared?: boolean;
  /**
   * Whether the calling thread decodes if no worker can be started: because a policy forbids it, or the page is from another
   * origin than the package, or there are no workers. A warning on the console then says why. By default true. Without it,
   * jobs reject with the code `failed`.
   */
  mainThread?: boolean;
}

export interface JobOptions {
  /** Ends the job: its promise rejects with the code `aborted`. */
  signal?: AbortSignal;
  /** Whether the data's buffer may be transferred to the worker: the caller's is then empty. */
  transfer?: boolean;
}

export interface ContainerOptions extends JobOptions {
  attributes?: AttributeRequest[];
  /** Called with the number of decoded patches, which grows, and their total; the last call has done = total. */
  onProgress?: (done: number, total: number) => void;
  /**
   * The number of workers that share the container's patches, if the pool has them. By default as many as its size pays for:
   * one for small containers.
   */
  workers?: number;
}

export interface StreamOptions extends Omit<ContainerOptions, 'transfer'> {
  /** Called with patches when they have arrived and are decoded, as by decodePatches. */
  onPart?: (part: DecodedPart, mesh: ContainerCounts) => void;
}

/** A primitive of a glTF file, by the numbers of its mesh and its place there. */
export interface PrimitivePlace {
  mesh: number;
  primitive: number;
}

/** What `choose` is told of a container when its head is there. Arrays have a number for each patch, boxes six. */
export interface PatchChoice extends Partial<PrimitivePlace> {
  patchCount: number;
  byteLengths: Uint32Array;
  faceCounts: Uint32Array;
  /** As in ContainerCounts. */
  boxes?: Float64Array;
}

/**
 * Chooses patches of a container by their numbers. They are fetched and decoded in this order. Nothing (undefined, null) stands for
 * the whole mesh.
 */
export type ChoosePatches = (container: PatchChoice) =>
  Iterable<number> | null | undefined | void | Promise<Iterable<number> | null | undefined | void>;

/** Of a mesh of chosen patches. */
export interface ChosenPatches {
  /** The numbers that `choose` returned: patch i of the mesh is patch `chosen[i]` of the container. */
  chosen?: Uint32Array;
}

export interface UrlOptions extends Omit<StreamOptions, 'onPart'> {
  /** Of containers of which some patches have arrived. */
  onProgress?: (done: number, total: number) => void;
  /** `place`: the first primitive that has the container. Without numbers, if the file is a container alone. */
  onPart?: (part: DecodedPart, mesh: ContainerCounts & ChosenPatches, place: Partial<PrimitivePlace>) => void;
  /**
   * Leaves patches out. The mesh then consists of the chosen ones alone, in their order, and counts only these. They share no
   * points: points at borders come once for each patch, and each corner of a face has the values that it has in the whole mesh. A
   * residue, which has nothing to draw, is left out. Errors have the numbers that patches have in the container. Rules of the
   * container that concern what is left out are not checked.
   *
   * If the server sends ranges of the file, and an ETag or a Last-Modified, other patches are not fetched. (Patches of
   * `gltf-psplit encode --condense` may need some that come before them, which are fetched as well.) If the file changes on
   * the way, the promise rejects with the code `failed`. Other servers, and a Response that is given, send the file up to the
   * last byte that is needed.
   */
  choose?: ChoosePatches | null;
}

/**
 * What decodeUrl makes of a file. Its primitives are as decodeContainer returns them. (decodeGltf of psplit/gltf also has those
 * that are not in patches, with attributes by name, when the whole file is there.)
 */
export interface DecodedFile {
  /** Of a glTF file; null of a container alone. */
  json: any;
  /** In the order of meshes and primitives, or without numbers the container alone. Equal primitives share their arrays. */
  primitives: (DecodedContainer & ChosenPatches & Partial<PrimitivePlace>)[];
}

/**
 * Decodes in workers. Jobs run side by side. A large container takes several workers if they are idle; the result is the
 * same. If a function that the caller gives throws, the job's promise rejects with what it threw.
 */
export interface Pool {
  /** Workers that run now; 0 while the calling thread decodes in their place. */
  readonly workerCount: number;
  ready(): Promise<void>;
  decodeDraco(data: Bytes, options?: { attributes?: DracoAttributeRequest[] } & JobOptions): Promise<DecodedMesh>;
  decodeContainer(data: Bytes, options?: ContainerOptions): Promise<DecodedContainer>;
  /** The same. Calls onPart with the patches as they are decoded, all before the promise resolves. `mesh`: of the whole. */
  decodePatches(data: Bytes, options: ContainerOptions & { onPart: (part: DecodedPart, mesh: ContainerCounts) => void }): Promise<DecodedContainer>;
  /**
   * The same for a container whose bytes arrive in order, in chunks of any length: patches are decoded when their bytes are
   * there. An error and an abort cancel the stream. One worker decodes, unless all bytes come before it has time.
   */
  decodeStream(stream: ReadableStream<Uint8Array> | AsyncIterable<Uint8Array>, options?: StreamOptions): Promise<DecodedContainer>;
  /**
   * Fetches a file, and decodes all its primitives in patches while it arrives: a GLB, a glTF file with its buffers, or a
   * container alone, for which `attributes` may be given. A glTF file's other primitives are left out. A Response that is
   * fetched already may be given. An abort ends the download as well. Errors have the numbers of the mesh and the primitive in
   * `mesh` and `primitive`.
   */
  decodeUrl(url: string | URL | Request | Response, options?: UrlOptions): Promise<DecodedFile>;
  /** Ends all workers. Jobs that are not done reject with the code `aborted`. */
  dispose(): void;
}

export function createPool(options?: PoolOptions): Pool;
