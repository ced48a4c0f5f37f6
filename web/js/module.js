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
  if (!response.ok) throw new Error(`${url}: HTTP status ${response.status}`);
  // Servers that send another type than application/wasm are common.
  const type = response.headers.get('Content-Type') ?? '';
  if (WebAssembly.compileStreaming !== undefined && type.startsWith('application/wasm'))
    return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}

/**
 * Compiles a module: a module, its bytes, or its address. By default psplit.wasm beside this file.
 * @returns {Promise<WebAssembly.Module>}
 */
export async function compile_module(wasm = wasm_file()) {
  if (wasm instanceof WebAssembly.Module) return wasm;
  try {
    if (wasm instanceof ArrayBuffer || ArrayBuffer.isView(wasm)) return await WebAssembly.compile(wasm);
    return await fetch_module(new URL(wasm, globalThis.location?.href));
  } catch (error) {
    throw new PsplitError(`psplit.wasm cannot be loaded: ${error.message}`, 'failed');
  }
}

let shared;

// The module beside this file. A failure is not kept: the next call tries again.
export function shared_module() {
  shared ??= compile_module().catch((error) => {
    shared = undefined;
    throw error;
  });
  return shared;
}
