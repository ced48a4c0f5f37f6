// The package in one file, with its WebAssembly module and its worker: for pages that cannot load a second file.
export * from './index.js';
