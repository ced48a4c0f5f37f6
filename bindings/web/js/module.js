// The compiled WebAssembly module. It is compiled once, and posted to workers.
import { compile_file } from './compile.js';
import { wasm_file } from './files.js';

/**
 * Compiles a module: a module, its bytes, or its address. By default that of configure(), or psplit.wasm beside this file.
 * @returns {Promise<WebAssembly.Module>}
 */
export const compile_module = (wasm) =>
  compile_file(wasm ?? configured.wasm, { name: 'psplit.wasm', file: wasm_file, has: 'open_container' });

let shared;

// The default module. A failure is not kept: the next call tries again.
export function shared_module() {
  const compiling = (shared ??= compile_module().catch((error) => {
    if (shared === compiling) shared = undefined;
    throw error;
  }));
  return compiling;
}

// What the package loads by default, if it is not the files beside this one.
export const configured = { wasm: undefined, worker: undefined };

export function configure(options) {
  const { wasm, worker } = options ?? {};
  Object.assign(configured, { wasm, worker });
  shared = undefined;
}
