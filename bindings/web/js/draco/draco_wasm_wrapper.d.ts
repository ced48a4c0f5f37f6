// The decoder's module, with the interface of draco3d's: see conformance.md. Its types are those of draco3d's module.

declare function createDecoderModule(config?: createDecoderModule.DecoderConfig): Promise<any>;
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
    onModuleLoaded?: (module: any) => void;
    onRuntimeInitialized?: () => void;
  }
}
export = createDecoderModule;
