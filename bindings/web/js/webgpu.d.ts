// Decodes containers of PSPLIT_mesh_draco_patches on a GPU, by WebGPU: to buffers that are drawn from.
import type { AttributeRequest, Bytes, ComponentType, DecodedMesh } from './index.js';

export { PsplitError } from './index.js';

/** A class of WebGPU, if the project's types have it. */
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
  /** Of the buffer's components: `uint16` of quantized values. */
  type: ComponentType;
  componentCount: number;
  normalized: boolean;
  /** The bytes from one point to the next, a multiple of 4. */
  stride: number;
  /** With the usages VERTEX, STORAGE, COPY_SRC and COPY_DST. Undefined if there is no device. */
  buffer: Buffer;
  /** Of quantized values: component k is `place * scale + origin[k]`, and places are below `2 ** bits`. */
  bits?: number;
  scale?: number;
  origin?: number[];
  /** The bounds of quantized positions that the GPU decoded. */
  min?: number[];
  max?: number[];
}

export interface GpuMesh {
  /** What decoded the container: the GPU, or WebAssembly, whose arrays were uploaded. */
  way: 'gpu' | 'wasm';
  /** Why it was WebAssembly. */
  why?: string;
  faceCount: number;
  pointCount: number;
  /** Three numbers of points for each face, with the usages INDEX, STORAGE, COPY_SRC and COPY_DST. */
  indices: { buffer: Buffer; format: 'uint32'; count: number };
  attributes: GpuAttribute[];
  /** Copies the mesh to arrays, without the gaps that a stride has. */
  read(): Promise<DecodedMesh>;
  /** Destroys the buffers. */
  destroy(): void;
}

export interface GpuDecoderOptions {
  /** Whether WebAssembly decodes if there is no device, if its limits are too small, and when it fails or is lost. */
  fallback?: 'wasm';
  /** The bytes of the device that streams are decoded in at one time. By default 128 MiB, or what the device's limits allow. */
  memory?: number;
}

export interface GpuDecodeOptions {
  /** As decodeContainer takes them; for a list of containers also a list of these lists. */
  attributes?: AttributeRequest[] | (AttributeRequest[] | undefined)[];
  /** How quantized values are written. By default `float32`. What WebAssembly decodes is always float32. */
  as?: 'float32' | 'quantized';
  signal?: AbortSignal;
}

export interface GpuDecoder {
  readonly device: Device | null;
  /** Several at once: their patches are decoded side by side. A broken container has its error in place of a mesh. */
  decode(data: (Bytes | Buffer | BufferRange)[], options?: GpuDecodeOptions): Promise<(GpuMesh | Error)[]>;
  decode(data: Bytes | Buffer | BufferRange, options?: GpuDecodeOptions): Promise<GpuMesh>;
}

/**
 * Compiles the shaders. The device stays the caller's: it may draw, and decode for any number of decoders.
 * Rejects with the code `failed` if there is no device or if its limits are too small, unless there is a fallback.
 */
export function createGpuDecoder(device: Device | null | undefined, options?: GpuDecoderOptions): Promise<GpuDecoder>;
