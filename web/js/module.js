// The compiled WebAssembly module. It is compiled once, and posted to workers.
import { PsplitError } from './error.js';
import { wasm_file } from './files.js';
import { is_node, node_module } from './node.js';

async function fetch_module(url) {
  if (is_node && url.protocol === 'file:') {
    const { readFile } = await node_module('node:fs/promises');
    return WebAssembly.compile(await readFile(url));
  }
  const response = await fetch(url);
  if (!response.ok) throw new Error(`HTTP status ${response.status}`);
  // Servers that send another type than application/wasm are common. Servers of pages that have one address for all send
  // the page.
  const type = response.headers.get('Content-Type') ?? '';
  const wrong = (what) => new Error(`the server sent ${what} WebAssembly`);
  if (WebAssembly.compileStreaming !== undefined && type.startsWith('application/wasm')) {
    return WebAssembly.compileStreaming(response).catch((error) => {
      throw /magic|asm'/.test(error.message) ? wrong('something else than') : error;
    });
  }
  const bytes = new Uint8Array(await response.arrayBuffer());
  if (String.fromCharCode(...bytes.subarray(0, 4)) !== '\0asm') throw wrong(`${type || 'something'} in place of`);
  return WebAssembly.compile(bytes);
}

async function compile(wasm) {
  if (wasm instanceof WebAssembly.Module) return wasm;
  let name = 'psplit.wasm';
  try {
    const file = wasm ?? wasm_file();
    if (file instanceof ArrayBuffer || ArrayBuffer.isView(file)) return await WebAssembly.compile(file);
    name = file;
    return await fetch_module(new URL(file, globalThis.location?.href));
  } catch (error) {
    throw new PsplitError(`${name} cannot be loaded: ${error.message}`, 'failed');
  }
}

/**
 * Compiles a module: a module, its bytes, or its address. By default that of configure(), or psplit.wasm beside this file.
 * @returns {Promise<WebAssembly.Module>}
 */
export async function compile_module(wasm) {
  const module = await compile(wasm ?? configured.wasm);
  if (!WebAssembly.Module.exports(module).some(({ name }) => name === 'open_container'))
    throw new PsplitError('the WebAssembly module is not psplit.wasm', 'failed');
  return module;
}

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
