// Decodes containers of PSPLIT_mesh_draco_patches on a GPU, by WebGPU, to buffers ready for drawing.
import type { AttributeRequest, Bytes, ComponentType, DecodedMesh } from './index.js';

export { PsplitError } from './index.js';

/** A class of WebGPU, if the project has types for WebGPU. */
type WebGpu<Name extends string> = typeof globalThis extends { [K in Name]: { prototype: infer T } } ? T : any;
export type Device = WebGpu<'GPUDevice'>;
export type Buffer = WebGpu<'GPUBuffer'>;

/** Bytes of a buffer that was created with COPY_SRC. */
export interface BufferRange {
  buffer: Buffer;
  offset?: number;
  byteLength?: number;
}

export interface GpuAttribute {
  name: string;
  uniqueId: number;
  /** The type of the buffer's components: `uint16` for quantized values. */
  type: ComponentType;
  componentCount: number;
  normalized: boolean;
  /** The bytes from one point to the next, a multiple of 4. */
  stride: number;
  /** Has the usages VERTEX, STORAGE, COPY_SRC and COPY_DST. Undefined without a device. */
  buffer: Buffer;
  /** For quantized values: component k is `place * scale + origin[k]`, where places are below `2 ** bits`. */
  bits?: number;
  scale?: number;
  origin?: number[];
  /** The bounds of quantized positions that the GPU decoded, if all patches have one grid. */
  min?: number[];
  max?: number[];
}

export interface GpuMesh {
  /** Whether the GPU decoded the container, or WebAssembly, whose arrays were uploaded. */
  way: 'gpu' | 'wasm';
  /** Why WebAssembly decoded it. */
  why?: string;
  faceCount: number;
  pointCount: number;
  patchCount: number;
  hasResidue: boolean;
  isCondensed: boolean;
  /** As in the result of decodeContainer. */
  firstFaces: Uint32Array;
  /** Three point indices for each face, with the usages INDEX, STORAGE, COPY_SRC and COPY_DST. */
  indices: { buffer: Buffer; format: 'uint32'; count: number };
  attributes: GpuAttribute[];
  /** Copies the mesh to tightly packed arrays. */
  read(): Promise<DecodedMesh>;
  /** Destroys the buffers. */
  destroy(): void;
}

export interface GpuDecoderOptions {
  /** Whether WebAssembly decodes if there is no device, if its limits are too small, and when it fails or is lost. */
  fallback?: 'wasm';
  /**
   * The device memory, in bytes (0 or more), for decoding streams at one time. By default 128 MiB, or less if the device's limits require it.
   */
  memory?: number;
}

export interface GpuDecodeOptions {
  /** As for decodeContainer; for a list of containers, optionally a list of such lists. */
  attributes?: AttributeRequest[] | (AttributeRequest[] | undefined)[];
  /** How quantized values are written. By default `float32`. WebAssembly always writes float32. */
  as?: 'float32' | 'quantized';
  /** Whether WebAssembly decodes what the shaders do not. By default true; otherwise such a container has an error with the code `unsupported`. */
  wasm?: boolean;
  signal?: AbortSignal;
}

export interface GpuDecoder {
  readonly device: Device | null;
  /**
   * Decodes several containers at once, all patches in parallel. For an invalid container, the result has the error in place of
   * the mesh.
   */
  decode(data: (Bytes | Buffer | BufferRange)[], options?: GpuDecodeOptions): Promise<(GpuMesh | Error)[]>;
  decode(data: Bytes | Buffer | BufferRange, options?: GpuDecodeOptions): Promise<GpuMesh>;
}

/**
 * Compiles the shaders, except those of condensed patches: the first `decode` of such patches loads and compiles them. The caller keeps the device, and may draw with it and use it for any number of decoders.
 * Rejects with the code `failed` if there is no device or if its limits are too small, unless there is a fallback.
 */
export function createGpuDecoder(device: Device | null | undefined, options?: GpuDecoderOptions): Promise<GpuDecoder>;
