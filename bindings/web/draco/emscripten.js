  // What emscripten gives a module: objects with addresses, memory, and ways to start. scripts/web puts this into the scripts
  // of decoder and encoder, which have to be files of their own.
  const kScript = typeof document !== 'undefined' ? document.currentScript?.src : undefined;
  const kIsNode = typeof process === 'object' && process.versions?.node !== undefined;
  // An instance that holds more memory than this is dropped if nothing lived in it for a while.
  const kMostKeptBytes = 64 * 1024 * 1024, kKeptMs = 2000;
  const kMostRoom = 2 ** 30;  // of memory that is taken in advance

  // An instance. Meshes and memory of _malloc stay in theirs.
  class Core {
    constructor(instance) {
      this.exports = instance.exports;
      this.live = 0;  // meshes, and memory of _malloc
      this.broken = false;
    }
    get buffer() {
      return this.exports.memory.buffer;
    }
    words(at, count) {
      return new Uint32Array(this.buffer, at, count);
    }
    allocate(bytes) {
      const at = bytes < 2 ** 32 ? this.exports.allocate(bytes) >>> 0 : 0;
      if (at === 0) throw new RangeError('psplit: out of memory');
      return at;
    }
    last_error() {
      const [code, , at, length] = this.words(this.exports.last_error(), 4);
      return { code, message: `psplit: ${String.fromCharCode(...new Uint8Array(this.buffer, at, length))}` };
    }
    // Calls an export that takes memory. If it is left by an exception, the instance cannot be used any more, but its memory and
    // what lives there stay as they are.
    call(name, ...rest) {
      try {
        if (this.broken) throw new Error('it was before');
        return this.exports[name](...rest);
      } catch (error) {
        this.broken = true;
        throw new RangeError(`psplit: out of memory (${error.message})`);
      }
    }
  }

  // `compiled`: what further instances are made of. Without it an instance that broke stays.
  class Memory {
    #compiled;
    #core;  // what works now
    #blocks = new Set();  // of _malloc
    #buffer;
    #views = {};  // of the buffer, by their names
    #timer;
    constructor({ instance, compiled }) {
      this.#compiled = compiled;
      // What _malloc takes memory from. It differs only while memory of _malloc lives in an instance that broke.
      this.heap = this.#core = new Core(instance);
    }
    usable_core() {
      clearTimeout(this.#timer);
      if (this.#core.broken) this.#renew();
      return this.#core;
    }
    #renew() {
      if (this.#compiled === undefined) return;
      this.#core = new Core(new WebAssembly.Instance(this.#compiled, {}));
      if (this.#blocks.size === 0) this.heap = this.#core;
    }
    // Something of an instance is freed.
    leave(left) {
      if (--left.live > 0 || left !== this.#core || left.buffer.byteLength <= kMostKeptBytes) return;
      this.#timer = setTimeout(() => this.#renew(), kKeptMs);
      this.#timer.unref?.();
    }
    add_members(module) {
      module._malloc = (bytes) => {
        if (this.#blocks.size === 0) this.heap = this.usable_core();
        const at = this.heap.allocate(bytes);
        this.#blocks.add(at);
        ++this.heap.live;
        this.look();
        return at;
      };
      module._free = (at) => {
        if (!this.#blocks.delete(at)) return;
        this.heap.exports.release(at);
        this.leave(this.heap);
        if (this.#blocks.size === 0) this.heap = this.#core;
      };
      for (const [name, Type] of Object.entries({ HEAP8: Int8Array, HEAPU8: Uint8Array, HEAP16: Int16Array, HEAPU16: Uint16Array,
        HEAP32: Int32Array, HEAPU32: Uint32Array, HEAPF32: Float32Array, HEAPF64: Float64Array }))
        Object.defineProperty(module, name, { configurable: true, get: () => {
          this.look();
          return (this.#views[name] ??= new Type(this.#buffer));
        } });
    }
    // To be called when memory may have grown. JavaScript detaches the views that pages have then. They become such that loaders which
    // took them before get the buffer of the memory where it is now, and the calls that they use go on. Only elements cannot be read by
    // their numbers.
    look() {
      const { buffer } = this.heap;
      if (buffer === this.#buffer) return;
      const call = (view, method) => ({ value: (...rest) => view.constructor.prototype[method].apply(new view.constructor(this.heap.buffer), rest) });
      for (const view of Object.values(this.#views))
        Object.defineProperties(view, { buffer: { get: () => this.heap.buffer }, subarray: call(view, 'subarray'), slice: call(view, 'slice'),
          set: call(view, 'set') });
      this.#views = {};
      this.#buffer = buffer;
    }
    // Takes room for what a page is about to allocate, so that the memory does not grow while the page has views of it.
    make_room(bytes) {
      const { allocate, release } = this.heap.exports;
      if (bytes < kMostRoom) release(allocate(bytes));
      this.look();
    }
  }

  function make_objects() {
    // Every object has an address that is its own, as emscripten's have.
    let last_pointer = 0;
    const objects = new Map();
    class WrapperObject {
      pointer_;
      // Objects that nobody asks for theirs are not kept: a status, for example, which nobody destroys.
      get ptr() {
        if (this.pointer_ === undefined) objects.set(this.pointer_ = last_pointer += 8, this);
        return this.pointer_;
      }
      __destroy__() {
        objects.delete(this.pointer_);
        this.pointer_ = 0;
      }
    }
    const null_of = (Class, members) => Object.assign(Object.create(Class.prototype), { pointer_: 0 }, members);
    const kNull = null_of(WrapperObject);
    const array_class = (Type, name) => class extends WrapperObject {
      array_ = new Type(0);
      name_ = name;
      // draco3d returns all numbers of 32 bits as signed ones.
      GetValue(i) { return Type === Uint32Array ? this.array_[i] | 0 : this.array_[i]; }
      size() { return this.array_.length; }
    };
    const members = {
      WrapperObject, VoidPtr: class VoidPtr extends WrapperObject {}, NULL: kNull,
      destroy(object) { object.__destroy__(); },
      getPointer: (object) => object.ptr,
      compare: (a, b) => a.ptr === b.ptr,
      getClass: (object) => object.constructor,
      wrapPointer: (pointer) => objects.get(pointer) ?? kNull,
      castObject: (object) => object,
      isVersionSupported: (version) => /^1\.[0-5](\.|$)/.test(version),
    };
    return { WrapperObject, null_of, array_class, members };
  }
  // Draco's metadata have bytes as names and as text. Strings of C end at a zero.
  const string_of_bytes = (bytes) => String.fromCharCode(...bytes);
  const bytes_of_text = (text) => new TextEncoder().encode(text.split('\0', 1)[0]);

  async function wasm_bytes(file, config) {
    if (config.wasmBinary !== undefined) return config.wasmBinary;
    if (kIsNode) {
      // eslint-disable-next-line no-undef
      return require('node:fs').readFileSync(config.locateFile?.(file) ?? require('node:path').join(__dirname, file));
    }
    const folder = kScript ?? globalThis.location?.href ?? '';
    const response = await fetch(config.locateFile?.(file) ?? new URL(file, folder));
    if (!response.ok) throw new Error(`psplit: ${file}: HTTP status ${response.status}`);
    return response.arrayBuffer();
  }

  // As emscripten calls it: instantiateWasm(imports, done), where done takes an instance and perhaps its module.
  const given_instance = (config) => new Promise((resolve) =>
    config.instantiateWasm({}, (instance, compiled) => resolve({ instance, compiled })));
  async function own_instance(file, config) {
    const compiled = await WebAssembly.compile(await wasm_bytes(file, config));
    return { instance: new WebAssembly.Instance(compiled, {}), compiled };
  }
  // `make` fills the configuration, which becomes the module, as emscripten does.
  const starter_of = (file, make) => async (config = {}) => {
    const module = make(await (config.instantiateWasm ? given_instance(config) : own_instance(file, config)), config);
    // The module is no promise: a `then` of its own would make `await` wait for ever.
    config.onRuntimeInitialized?.();
    config.onModuleLoaded?.(module);
    return module;
  };
