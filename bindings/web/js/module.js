// The compiled WebAssembly modules. Each is compiled once, and posted to workers.
import { compile_file, once } from './compile.js';
import { condensed_wasm_file, wasm_file } from './files.js';
import { is_condensed } from './head.js';

// An export of the modules that decode condensed patches.
const kReadsCondensed = 'reads_condensed';

/**
 * Compiles a module: a module, its bytes, or its address. By default that of configure(), or psplit.wasm beside this file.
 * @returns {Promise<WebAssembly.Module>}
 */
export const compile_module = (wasm) =>
  compile_file(wasm ?? configured.wasm, { name: 'psplit.wasm', file: wasm_file, has: 'open_container' });
// Likewise for psplit_condensed.wasm, which also decodes condensed patches.
const compile_condensed = (wasm) =>
  compile_file(wasm ?? configured.condensedWasm, { name: 'psplit_condensed.wasm', file: condensed_wasm_file, has: kReadsCondensed });

// What the package loads by default, if it is not the files beside this one.
export const configured = { wasm: undefined, condensedWasm: undefined, worker: undefined };

// The default modules.
let shared = once(() => compile_module()), condensed = once(() => compile_condensed());
export const shared_module = () => shared();
export const condensed_module = () => condensed();

export function configure(options) {
  const { wasm, condensedWasm, worker } = options ?? {};
  Object.assign(configured, { wasm, condensedWasm, worker });
  shared = once(() => compile_module());
  condensed = once(() => compile_condensed());
}

/**
 * What decodes a container: the module that there is, or psplit_condensed.wasm if it needs that.
 * @param {Uint8Array} front the container's bytes to the first of its head, or more
 * @param {WebAssembly.Module} module
 * @param {*} [wasm] a module that reads condensed patches, its bytes, or its address, if it is not the default one
 * @returns {Promise<WebAssembly.Module>}
 */
export async function module_for(front, module, wasm) {
  const reads_all = () => WebAssembly.Module.exports(module).some(({ name }) => name === kReadsCondensed);
  if (!is_condensed(front) || reads_all()) return module;
  return wasm == null ? condensed() : compile_condensed(wasm);
}
