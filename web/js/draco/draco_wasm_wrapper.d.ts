// The decoder's module, with the interface of draco3d's: see conformance.md. Its types are those of draco3d's module.

export interface DecoderConfig {
  /** The bytes of draco_decoder.wasm. By default they are loaded from beside the script. */
  wasmBinary?: ArrayBuffer | Uint8Array;
  /** Returns the address of a file, in Node.js its path. */
  locateFile?: (file: string) => string;
  onModuleLoaded?: (module: any) => void;
  onRuntimeInitialized?: () => void;
}

declare function createDecoderModule(config?: DecoderConfig): Promise<any>;
declare namespace createDecoderModule {
  export { createDecoderModule };
}
export = createDecoderModule;
