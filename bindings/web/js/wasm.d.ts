// What bundlers and edge runtimes make of an imported .wasm file of the package: `configure` takes it.

declare const module: WebAssembly.Module;
export default module;
