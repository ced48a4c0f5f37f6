// Compiles a WebAssembly module of the package.
import { PsplitError } from './error.js';
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

async function compile(wasm, { name, file }) {
  if (wasm instanceof WebAssembly.Module) return wasm;
  let at = name;
  try {
    const found = wasm ?? file();
    if (found instanceof ArrayBuffer || ArrayBuffer.isView(found)) return await WebAssembly.compile(found);
    at = found;
    return await fetch_module(new URL(found, globalThis.location?.href));
  } catch (error) {
    throw new PsplitError(`${at} cannot be loaded: ${error.message}`, 'failed');
  }
}

/**
 * A function that returns what make() promised when it was called first. A failure is not kept: the next call tries again.
 * `has_begun` of it tells whether there is such a promise.
 */
export function once(make) {
  let made;
  const get = () => {
    const making = (made ??= make().catch((error) => {
      if (made === making) made = undefined;
      throw error;
    }));
    return making;
  };
  return Object.assign(get, { has_begun: () => made !== undefined });
}

export const has_export = (module, name) => WebAssembly.Module.exports(module).some((of) => of.name === name);

/**
 * Compiles a module: a module, its bytes, or its address; by default `file()`. `has` is an export by which it is known.
 * @returns {Promise<WebAssembly.Module>}
 */
export async function compile_file(wasm, { name, file, has }) {
  const module = await compile(wasm, { name, file });
  if (!has_export(module, has)) throw new PsplitError(`the WebAssembly module is not ${name}`, 'failed');
  return module;
}
