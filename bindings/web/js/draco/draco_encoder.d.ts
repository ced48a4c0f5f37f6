// The encoder's module, with the interface of draco3d's: see encoder.md.

declare function createEncoderModule(config?: createEncoderModule.EncoderConfig): Promise<createEncoderModule.EncoderModule>;
declare namespace createEncoderModule {
  export { createEncoderModule };

  export interface EncoderConfig {
    /** The bytes of draco_encoder.wasm. By default they are loaded from beside the script. */
    wasmBinary?: ArrayBuffer | Uint8Array;
    /**
     * Makes the instance, as for emscripten: `done` takes it, and perhaps its module. Without the module an encoder that ran
     * out of memory stays so.
     */
    instantiateWasm?: (imports: WebAssembly.Imports, done: (instance: WebAssembly.Instance, module?: WebAssembly.Module) => void) => unknown;
    /** Returns the address of a file, in Node.js its path. */
    locateFile?: (file: string) => string;
    onModuleLoaded?: (module: EncoderModule) => void;
    onRuntimeInitialized?: () => void;
  }

  // Objects of the module. Each stays until `destroy`.

  export interface WrapperObject { readonly ptr: number }
  export interface PointCloud extends WrapperObject { num_attributes(): number; num_points(): number }
  export interface Mesh extends PointCloud { num_faces(): number; set_num_points(count: number): void }
  export interface DracoInt8Array extends WrapperObject { GetValue(index: number): number; size(): number }
  export interface Metadata extends WrapperObject {}
  export interface MetadataBuilder extends WrapperObject {
    AddStringEntry(metadata: Metadata, name: string, value: string): boolean;
    AddIntEntry(metadata: Metadata, name: string, value: number): boolean;
    AddIntEntryArray(metadata: Metadata, name: string, values: Int32Array, count: number): boolean;
    AddDoubleEntry(metadata: Metadata, name: string, value: number): boolean;
  }
  /** Adds an attribute with a value for each point. Returns its id. */
  export type Add<Values> = (cloud: PointCloud, semantic: number, count: number, components: number, values: Values) => number;
  export interface PointCloudBuilder extends WrapperObject {
    AddFloatAttribute: Add<Float32Array>;
    AddInt8Attribute: Add<Int8Array>;
    AddUInt8Attribute: Add<Uint8Array>;
    AddInt16Attribute: Add<Int16Array>;
    AddUInt16Attribute: Add<Uint16Array>;
    AddInt32Attribute: Add<Int32Array>;
    AddUInt32Attribute: Add<Uint32Array>;
    AddMetadata(cloud: PointCloud, metadata: Metadata): boolean;
    SetMetadataForAttribute(cloud: PointCloud, id: number, metadata: Metadata): boolean;
    SetNormalizedFlagForAttribute(cloud: PointCloud, id: number, normalized: boolean): boolean;
  }
  export interface MeshBuilder extends PointCloudBuilder {
    AddFacesToMesh(mesh: Mesh, count: number, faces: Uint32Array | Uint16Array | Int32Array): boolean;
    AddFloatAttributeToMesh: Add<Float32Array>;
    AddInt32AttributeToMesh: Add<Int32Array>;
    AddMetadataToMesh(mesh: Mesh, metadata: Metadata): boolean;
  }
  export interface AnyEncoder extends WrapperObject {
    SetSpeedOptions(encoding: number, decoding: number): void;
    SetEncodingMethod(method: number): void;
    SetTrackEncodedProperties(tracks: boolean): void;
    /** The key is the type of attributes; for an ExpertEncoder it is the id of one. */
    SetAttributeQuantization(key: number, bits: number): void;
    SetAttributeExplicitQuantization(key: number, bits: number, components: number, origin: ArrayLike<number>, range: number): void;
    GetNumberOfEncodedPoints(): number;
    GetNumberOfEncodedFaces(): number;
  }
  export interface Encoder extends AnyEncoder {
    /** Returns the length of the stream, or 0. */
    EncodeMeshToDracoBuffer(mesh: Mesh, out: DracoInt8Array): number;
    EncodePointCloudToDracoBuffer(cloud: PointCloud, deduplicate: boolean, out: DracoInt8Array): number;
  }
  export interface ExpertEncoder extends AnyEncoder {
    EncodeToDracoBuffer(deduplicate: boolean, out: DracoInt8Array): number;
  }

  export interface EncoderModule {
    Encoder: new () => Encoder;
    ExpertEncoder: new (mesh: Mesh | PointCloud) => ExpertEncoder;
    Mesh: new () => Mesh;
    PointCloud: new () => PointCloud;
    MeshBuilder: new () => MeshBuilder;
    PointCloudBuilder: new () => PointCloudBuilder;
    Metadata: new () => Metadata;
    MetadataBuilder: new () => MetadataBuilder;
    DracoInt8Array: new () => DracoInt8Array;
    destroy(object: WrapperObject): void;
    getPointer(object: WrapperObject): number;
    readonly POSITION: number; readonly NORMAL: number; readonly COLOR: number; readonly TEX_COORD: number;
    readonly GENERIC: number; readonly INVALID: number; readonly POINT_CLOUD: number; readonly TRIANGULAR_MESH: number;
    readonly INVALID_GEOMETRY_TYPE: number; readonly MESH_SEQUENTIAL_ENCODING: number;
    readonly MESH_EDGEBREAKER_ENCODING: number;
  }
}
export = createEncoderModule;
