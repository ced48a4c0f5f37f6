// The decoder's module, with the interface of draco3d's: see conformance.md. What draco3d takes and returns is not said here.

declare function createDecoderModule(config?: createDecoderModule.DecoderConfig): Promise<createDecoderModule.DecoderModule>;
declare namespace createDecoderModule {
  export { createDecoderModule };

  /** draco3d for loaders that pass no configuration: see `DecoderConfig`. */
  export let draco3d: string | object | undefined;

  export interface DecoderConfig {
    /** The bytes of draco_decoder.wasm. By default they are loaded from beside the script. */
    wasmBinary?: ArrayBuffer | Uint8Array;
    /**
     * Makes the instance, as for emscripten: `done` takes it, and perhaps its module. Without the module a decoder that ran
     * out of memory stays so.
     */
    instantiateWasm?: (imports: WebAssembly.Imports, done: (instance: WebAssembly.Instance, module?: WebAssembly.Module) => void) => unknown;
    /** Returns the address of a file, in Node.js its path. */
    locateFile?: (file: string) => string;
    /**
     * draco3d, for bitstreams older than 2.2: its module, or the address of the folder that has its draco_wasm_wrapper.js
     * and draco_decoder.wasm. Classic workers load these when the first such stream comes; elsewhere it must be the module.
     */
    draco3d?: string | object;
    onModuleLoaded?: (module: DecoderModule) => void;
    onRuntimeInitialized?: () => void;
  }

  // Objects of the module. Each stays until `destroy`.

  export interface WrapperObject { readonly ptr: number }
  export interface Status extends WrapperObject { code(): number; ok(): boolean; error_msg(): string }
  export interface DecoderBuffer extends WrapperObject { Init(data: Int8Array | Uint8Array | ArrayBuffer, size: number): void }
  export interface PointCloud extends WrapperObject { num_attributes(): number; num_points(): number }
  export interface Mesh extends PointCloud { num_faces(): number }
  export interface AttributeTransformData extends WrapperObject { transform_type(): number }
  export interface PointAttribute extends WrapperObject {
    size(): number;
    attribute_type(): number;
    data_type(): number;
    num_components(): number;
    normalized(): boolean;
    byte_stride(): number;
    byte_offset(): number;
    unique_id(): number;
    GetAttributeTransformData(): AttributeTransformData;
  }
  export interface AttributeQuantizationTransform extends WrapperObject {
    InitFromAttribute(attribute: PointAttribute): boolean;
    quantization_bits(): number;
    min_value(axis: number): number;
    range(): number;
  }
  export interface AttributeOctahedronTransform extends WrapperObject {
    InitFromAttribute(attribute: PointAttribute): boolean;
    quantization_bits(): number;
  }
  export interface DracoArray extends WrapperObject { GetValue(index: number): number; size(): number }
  export interface Metadata extends WrapperObject {}
  export interface MetadataQuerier extends WrapperObject {
    HasEntry(metadata: Metadata, name: string): boolean;
    GetIntEntry(metadata: Metadata, name: string): number;
    GetIntEntryArray(metadata: Metadata, name: string, out: DracoArray): void;
    GetDoubleEntry(metadata: Metadata, name: string): number;
    GetStringEntry(metadata: Metadata, name: string): string;
    NumEntries(metadata: Metadata): number;
    GetEntryName(metadata: Metadata, number: number): string;
  }
  export type Bytes = Int8Array | Uint8Array | ArrayBuffer;
  export type Values = (cloud: PointCloud, attribute: PointAttribute, out: DracoArray) => boolean;
  export interface Decoder extends WrapperObject {
    GetEncodedGeometryType(data: DecoderBuffer | Bytes): number;
    DecodeArrayToMesh(data: Bytes, size: number, mesh: Mesh): Status;
    DecodeBufferToMesh(buffer: DecoderBuffer, mesh: Mesh): Status;
    DecodeArrayToPointCloud(data: Bytes, size: number, cloud: PointCloud): Status;
    DecodeBufferToPointCloud(buffer: DecoderBuffer, cloud: PointCloud): Status;
    SkipAttributeTransform(semantic: number): void;
    GetAttributeId(cloud: PointCloud, semantic: number): number;
    GetAttribute(cloud: PointCloud, id: number): PointAttribute;
    GetAttributeByUniqueId(cloud: PointCloud, uniqueId: number): PointAttribute;
    GetAttributeIdByName(cloud: PointCloud, name: string): number;
    GetAttributeIdByMetadataEntry(cloud: PointCloud, name: string, value: string): number;
    GetMetadata(cloud: PointCloud): Metadata;
    GetAttributeMetadata(cloud: PointCloud, id: number): Metadata;
    /** Each writes `size` bytes to `at`, which is an address of `_malloc`. */
    GetTrianglesUInt16Array(mesh: Mesh, size: number, at: number): boolean;
    GetTrianglesUInt32Array(mesh: Mesh, size: number, at: number): boolean;
    GetAttributeDataArrayForAllPoints(cloud: PointCloud, attribute: PointAttribute, type: number, size: number, at: number): boolean;
    GetFaceFromMesh(mesh: Mesh, face: number, out: DracoArray): boolean;
    GetAttributeFloat(attribute: PointAttribute, number: number, out: DracoArray): boolean;
    GetAttributeFloatForAllPoints: Values;
    GetAttributeIntForAllPoints: Values;
    GetAttributeInt8ForAllPoints: Values;
    GetAttributeUInt8ForAllPoints: Values;
    GetAttributeInt16ForAllPoints: Values;
    GetAttributeUInt16ForAllPoints: Values;
    GetAttributeInt32ForAllPoints: Values;
    GetAttributeUInt32ForAllPoints: Values;
  }

  export interface DecoderModule {
    Decoder: new () => Decoder;
    DecoderBuffer: new () => DecoderBuffer;
    Mesh: new () => Mesh;
    PointCloud: new () => PointCloud;
    PointAttribute: new (...none: never[]) => PointAttribute;
    AttributeQuantizationTransform: new () => AttributeQuantizationTransform;
    AttributeOctahedronTransform: new () => AttributeOctahedronTransform;
    MetadataQuerier: new () => MetadataQuerier;
    Metadata: new () => Metadata;
    Status: new () => Status;
    DracoFloat32Array: new () => DracoArray;
    DracoInt8Array: new () => DracoArray;
    DracoUInt8Array: new () => DracoArray;
    DracoInt16Array: new () => DracoArray;
    DracoUInt16Array: new () => DracoArray;
    DracoInt32Array: new () => DracoArray;
    DracoUInt32Array: new () => DracoArray;
    destroy(object: WrapperObject): void;
    getPointer(object: WrapperObject): number;
    compare(a: WrapperObject, b: WrapperObject): boolean;
    _malloc(bytes: number): number;
    _free(at: number): void;
    readonly HEAP8: Int8Array;
    readonly HEAPU8: Uint8Array;
    readonly HEAP16: Int16Array;
    readonly HEAPU16: Uint16Array;
    readonly HEAP32: Int32Array;
    readonly HEAPU32: Uint32Array;
    readonly HEAPF32: Float32Array;
    readonly HEAPF64: Float64Array;
    readonly ATTRIBUTE_INVALID_TRANSFORM: number; readonly ATTRIBUTE_NO_TRANSFORM: number;
    readonly ATTRIBUTE_QUANTIZATION_TRANSFORM: number; readonly ATTRIBUTE_OCTAHEDRON_TRANSFORM: number;
    readonly INVALID: number; readonly POSITION: number; readonly NORMAL: number; readonly COLOR: number;
    readonly TEX_COORD: number; readonly GENERIC: number; readonly INVALID_GEOMETRY_TYPE: number;
    readonly POINT_CLOUD: number; readonly TRIANGULAR_MESH: number; readonly DT_INVALID: number; readonly DT_INT8: number;
    readonly DT_UINT8: number; readonly DT_INT16: number; readonly DT_UINT16: number; readonly DT_INT32: number;
    readonly DT_UINT32: number; readonly DT_INT64: number; readonly DT_UINT64: number; readonly DT_FLOAT32: number;
    readonly DT_FLOAT64: number; readonly DT_BOOL: number; readonly DT_TYPES_COUNT: number; readonly OK: number;
    readonly DRACO_ERROR: number; readonly IO_ERROR: number; readonly INVALID_PARAMETER: number;
    readonly UNSUPPORTED_VERSION: number; readonly UNKNOWN_VERSION: number;
  }
}
export = createDecoderModule;
