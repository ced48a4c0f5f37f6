// The encoder's module, with the interface of draco3d's: see encoder.md. Its types are those of draco3d's module.

declare function createEncoderModule(config?: createEncoderModule.EncoderConfig): Promise<any>;
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
    onModuleLoaded?: (module: any) => void;
    onRuntimeInitialized?: () => void;
  }
}
export = createEncoderModule;
