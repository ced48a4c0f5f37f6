// The compiled WebAssembly modules. Each is compiled once, and posted to workers.
import { compile_file, has_export, once } from './compile.js';
import { condensed_wasm_file, wasm_file } from './files.js';

// An export of the modules that decode condensed patches.
const kReadsCondensed = 'reads_condensed';

const compile_module = (wasm) =>
  compile_file(wasm ?? configured.wasm, { name: 'psplit.wasm', file: wasm_file, has: 'open_container' });
const compile_condensed = (wasm) =>
  compile_file(wasm ?? configured.condensedWasm, { name: 'psplit_condensed.wasm', file: condensed_wasm_file, has: kReadsCondensed });

// What the package loads by default, if it is not the files beside this one.
export const configured = { wasm: undefined, condensedWasm: undefined, worker: undefined };

// The default modules.
let shared_plain, shared_condensed;
export function configure(options) {
  const { wasm, condensedWasm, worker } = options ?? {};
  Object.assign(configured, { wasm, condensedWasm, worker });
  shared_plain = once(() => compile_module());
  shared_condensed = once(() => compile_condensed());
}
configure();

/**
 * The modules of a pool: psplit.wasm, and psplit_condensed.wasm, which decodes all. Each is loaded when it is needed, and neither beside
 * the other if that one will do.
 */
export class Modules {
  #own_plain = null;
  #own_condensed = null;

  /** Takes modules, their bytes, or their addresses. The defaults are configure()'s, or the files beside this one. */
  constructor(wasm, condensed_wasm) {
    if (wasm != null) this.#own_plain = once(() => compile_module(wasm));
    if (condensed_wasm != null) this.#own_condensed = once(() => compile_condensed(condensed_wasm));
  }

  /**
   * What decodes Draco streams and patches of them, and if it `reads_condensed` also condensed patches. A module that the caller named
   * may do so as well.
   * @returns {Promise<WebAssembly.Module>}
   */
  async get(reads_condensed) {
    const plain = this.#own_plain ?? shared_plain, condensed = this.#own_condensed ?? shared_condensed;
    const may_be_all = this.#own_plain !== null || configured.wasm != null || wasm_file === condensed_wasm_file;
    if (!reads_condensed) return may_be_all || !condensed.has_begun() ? plain() : condensed().catch(plain);
    const module = may_be_all ? await plain() : null;
    return module !== null && has_export(module, kReadsCondensed) ? module : condensed();
  }
}
export const shared_modules = new Modules();
